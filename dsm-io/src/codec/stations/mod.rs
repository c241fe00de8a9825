//! Block 2: functions on grids as coded numbers.
//!
//! A pixel's vertices are *stations*: a step, of two vertices at one depth, or a corner,
//! of one. Corners lie on a grid of their pixel's own, which is coarser than that of
//! steps; depths, values and numbers of stations are told as what they differ from what
//! neighbours and vertices before make likely. The numbers are of kinds, so that what
//! is frequent among its like is short.

mod decode;
mod encode;
mod kinds;

pub(super) use decode::{Columns, decode};
pub(super) use encode::encode;

#[cfg(test)]
mod tests {
    use dsm_core::detail::PixelLists;
    use dsm_core::{PixelListsBuilder, Rgb, Transmittance, Vertex};
    use proptest::prelude::*;

    use super::*;
    use crate::codec::grids::Grids;

    /// Any functions on grids: for each pixel its vertices, each by how many points of the
    /// grid of depths it lies behind the one before, and how far its channels fall.
    fn lists<T: Transmittance>(width: u32, pixels: &[Vec<(u32, [u8; 3])>]) -> PixelLists<T> {
        let mut builder = PixelListsBuilder::new(width, pixels.len() as u32 / width);
        for pixel in pixels {
            let (mut depth, mut left, mut alike) = (0_u32, [255_u8; 3], 0);
            for (index, &(behind, falls)) in pixel.iter().enumerate() {
                alike = if behind == 0 { alike + 1 } else { 0 };
                depth += if alike > 1 { 1 } else { behind };
                alike %= 2;
                if index > 0 {
                    left =
                        std::array::from_fn(|channel| left[channel].saturating_sub(falls[channel]));
                }
                let is_mono = falls[2] % 2 == 0 && index == 0 || pixel[0].1[2] % 2 == 0;
                let value = T::from_channels(|channel| {
                    f32::from(left[if is_mono { 0 } else { channel }]) / 256.0
                });
                let value = if index == 0 { T::CLEAR } else { value };
                builder.push(Vertex::new(f32::from_bits(depth << 8), value));
            }
            builder.finish_pixel().unwrap();
        }
        builder.finish().unwrap()
    }

    fn check<T: Transmittance>(pixels: &PixelLists<T>, flips: &[(usize, u8)]) {
        let view = pixels.view();
        let grids = Grids::of(view).unwrap();
        let payload = encode(view, grids);
        let size = [view.width(), view.height()];
        let counts = [view.depths().len(), view.values().len()];
        let again = |payload: &[u8]| decode(payload, size, T::CHANNELS, counts);
        let Columns { starts, value_starts, depths, values } = again(&payload).unwrap();
        assert_eq!((&starts[..], &depths[..]), (view.starts(), view.depths()));
        assert_eq!((&value_starts[..], &values[..]), (view.value_starts(), view.values()));
        // Other counts are refused, and damage is, or gives columns of these lengths.
        for wrong in [[counts[0] + 1, counts[1]], [counts[0], counts[1] + 1]] {
            let other = decode(&payload, size, T::CHANNELS, wrong);
            assert!(other.is_err() || T::CHANNELS == 1 && wrong[0] == counts[0]);
        }
        for &(at, mask) in flips {
            let mut damaged = payload.clone();
            let at = at % damaged.len();
            damaged[at] ^= mask;
            if let Ok(columns) = again(&damaged) {
                assert_eq!([columns.depths.len(), columns.values.len()], counts);
            }
            damaged.truncate(at);
            let _ = again(&damaged);
        }
    }

    proptest! {
        #![proptest_config(dsm_testkit::config(200))]

        #[test]
        fn functions_come_back(
            width in 1_u32..5,
            pixels in prop::collection::vec(
                prop::collection::vec((prop_oneof![Just(0_u32), 0_u32..9, 0..30_000_u32], any::<[u8; 3]>()), 0..9),
                4..60,
            ),
            flips in prop::collection::vec((any::<usize>(), 1_u8..), 20),
        ) {
            let whole = pixels.len() / width as usize * width as usize;
            check::<f32>(&lists(width, &pixels[..whole]), &flips);
            check::<Rgb>(&lists(width, &pixels[..whole]), &flips);
        }
    }
}
