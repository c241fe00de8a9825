//! Layers that a bound leaves no room for, folded into the last one.

use dsm_core::Transmittance;

use super::fragment::Fragment;

/// Folds all but the `most` − 1 nearest of a pixel's `fragments`, which come with the
/// farthest first, into one at the farthest, so that as much light gets past all of them
/// together as before. Returns the most light that is gained between them by that: the mean
/// over the pixel, at the depth and in the channel where it is most.
///
/// No ray through the pixel loses light that got past the layers before, and the farthest,
/// often what the others stand on, does not shade itself.
pub(super) fn fold<T: Transmittance>(fragments: &mut Vec<Fragment<T>>, most: usize) -> f64 {
    let Some(cut) = fragments.len().checked_sub(most.max(1)).filter(|&cut| cut > 0) else {
        return 0.0;
    };
    let (rest, kept) = fragments.split_at(cut + 1);
    let through = |some: &[Fragment<T>], square: u32, channel: usize| -> f64 {
        let covering = some.iter().filter(|one| one.coverage >> square & 1 == 1);
        covering.map(|one| 1.0 - f64::from(one.opacity.channel(channel))).product()
    };
    let mut gained: f64 = 0.0;
    let coverage = rest.iter().fold(0, |all, one| all | one.coverage);
    let opacity = T::from_channels(|channel| {
        let (mut arrives, mut stopped, mut alone, mut before) = (0.0, 0.0, 0.0, 0.0);
        for square in (0..64).filter(|square| coverage >> square & 1 == 1) {
            let light = through(kept, square, channel);
            let share = 1.0 - through(rest, square, channel);
            arrives += light;
            stopped += light * share;
            alone += share;
            before += light * (1.0 - through(&rest[1..], square, channel));
        }
        gained = gained.max(before / 64.0);
        // Where nothing arrives, as if it did.
        let share = if arrives > 0.0 {
            stopped / arrives
        } else {
            alone / f64::from(coverage.count_ones())
        };
        share.min(1.0) as f32
    });
    let folded = Fragment { opacity, coverage, ..rest[0] };
    fragments.splice(..=cut, [folded]);
    gained
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_much_light_gets_past_all_and_more_past_some() {
        let one = |w: f32, opacity: f32, coverage| Fragment {
            w,
            gradient: Some([0.0; 2]),
            opacity,
            coverage,
        };
        let (half, whole) = (0xffff_ffff, u64::MAX);
        let all =
            [one(0.1, 0.5, whole), one(0.2, 0.5, half), one(0.3, 0.25, whole), one(0.4, 0.5, half)];
        let light = |list: &[Fragment<f32>]| -> f64 {
            let square = |square: u32| -> f64 {
                let some = list.iter().filter(|one| one.coverage >> square & 1 == 1);
                some.map(|one| 1.0 - f64::from(one.opacity)).product()
            };
            (0..64).map(square).sum::<f64>() / 64.0
        };
        for most in 1..=5 {
            let mut list = all.to_vec();
            let gained = fold(&mut list, most);
            assert_eq!(list.len(), most.min(4));
            assert!((light(&list) - light(&all)).abs() < 1e-6, "{most}");
            assert_eq!(list[0].w, 0.1, "the farthest stays");
            assert_eq!(list[1..], all[5 - most.min(4)..], "so do the nearest");
            // Just before the farthest.
            let expected = light(&list[1..]) - light(&all[1..]);
            assert!((gained - expected).abs() < 1e-6, "{most}: {gained} {expected}");
        }
    }
}
