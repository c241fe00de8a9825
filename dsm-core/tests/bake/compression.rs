//! Bakes by each compressor, to each side.

use dsm_core::detail::{Quantization, VisibilityDifference};
use dsm_core::{
    BakeSettings, Baker, Compression, CompressionMethod, Rgb, Side, Tolerance, Transmittance,
};
use dsm_testkit::config;
use proptest::prelude::*;

use crate::pixels::{scenes, settings};
use crate::sources::RandomScene;

const MIN_LINK: Compression = Compression::new(CompressionMethod::MinLink);

/// Every pixel within the tolerance of its uncompressed function and on the side that was
/// asked for; and not more vertices than greedy compression leaves.
fn check<T: Transmittance>(
    scene: RandomScene,
    settings: &BakeSettings,
    side: Side,
    quantization: Option<Quantization>,
) -> Result<(), TestCaseError> {
    let mut settings = settings.clone();
    settings.tolerance = Some(Tolerance::new(0.0625).unwrap());
    settings.quantization = quantization;
    settings.compression = MIN_LINK.with_side(side);
    let baker = Baker::<T, _>::new(scene, settings.clone()).unwrap();
    prop_assert_eq!(baker.info().compression, Some(settings.compression));
    for tile in settings.tiles() {
        let baked = baker.tile(tile).unwrap();
        prop_assert!(baked.max_error() <= 0.0625 + 1e-7, "{}", baked.max_error());
        let first = tile.map(|index| index * settings.tile_size);
        let mut off = Ok(());
        let visit = |pixel: dsm_core::detail::ExactPixel<'_, T>| {
            let [x, y] = [0, 1].map(|axis| pixel.pixel()[axis] - first[axis]);
            let stored = baked.pixels().view();
            let stored = stored.pixel(x, y);
            for vertex in stored.vertices() {
                let exact = VisibilityDifference::between(pixel.vertices(), &stored);
                if exact.max() > 0.0625 && quantization.is_none() {
                    off = Err(format!("{exact:?}"));
                }
                for channel in 0..T::CHANNELS {
                    let (z, at) = (vertex.z, f64::from(vertex.value.channel(channel)));
                    let exact =
                        crate::quantized::value::<T>(pixel.vertices(), z.into(), channel, true);
                    let before = f64::from(stored.before(z).channel(channel));
                    let exact_before =
                        crate::quantized::value::<T>(pixel.vertices(), z.into(), channel, false);
                    let at = f64::from(stored.at(z).channel(channel)).min(at);
                    let is_kept = match side {
                        Side::Both => true,
                        // A lookup rounds.
                        Side::Lighter => at >= exact - 1e-7 && before >= exact_before - 1e-7,
                        Side::Darker => at <= exact + 1e-7 && before <= exact_before + 1e-7,
                    };
                    if !is_kept {
                        off = Err(format!("{side:?} {z}: {before} {at}, {exact_before} {exact}"));
                    }
                }
            }
        };
        baker.exact_tile(tile, visit).unwrap();
        prop_assert!(off.is_ok(), "{off:?}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(181))]

    #[test]
    fn fewest_vertices_keep_the_bound_and_the_side(
        scene in scenes(),
        settings in settings(),
        side in prop_oneof![Just(Side::Both), Just(Side::Lighter), Just(Side::Darker)],
    ) {
        check::<f32>(scene, &settings, side, None)?;
        check::<Rgb>(scene, &settings, side, None)?;
    }

    #[test]
    fn grids_keep_the_lighter_side(scene in scenes(), settings in settings()) {
        check::<f32>(scene, &settings, Side::Lighter, Some(Quantization::default()))?;
        check::<Rgb>(scene, &settings, Side::Lighter, Some(Quantization::default()))?;
    }
}

#[test]
fn what_can_not_keep_to_a_side_is_refused() {
    let scene = RandomScene { seed: 7, on_grid: false, media: 5, backwards: false };
    let settings = BakeSettings::new([4, 4]).unwrap();
    let made = |compression, quantization: Option<Quantization>| {
        let settings = settings.clone().with_compression(compression);
        Baker::<f32, _>::new(scene, settings.with_quantization(quantization)).is_ok()
    };
    let greedy = Compression::new(CompressionMethod::Greedy);
    assert!(made(greedy, None) && !made(greedy.with_side(Side::Lighter), None));
    assert!(made(MIN_LINK.with_side(Side::Darker), None));
    // Depths on grids lie behind, where V is lighter.
    assert!(!made(MIN_LINK.with_side(Side::Darker), Some(Quantization::default())));
    assert!(made(MIN_LINK.with_side(Side::Lighter), Some(Quantization::default())));
}
