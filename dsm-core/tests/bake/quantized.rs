//! Maps whose vertices are rounded to grids.

use dsm_core::detail::{Quantization, SumVertex, VisibilityView};
use dsm_core::{
    BakeSettings, Baker, Error, PixelSampling, RayHits, RaySource, Rgb, SamplePoint, SurfaceHit,
    Tolerance, Transmittance,
};
use dsm_testkit::config;
use proptest::prelude::*;

use crate::pixels::{scenes, settings};
use crate::sources::RandomScene;

/// V(z), or its limit from the light's side, of uncompressed vertices.
pub(crate) fn value<T: Transmittance>(
    vertices: &[SumVertex<T>],
    z: f64,
    channel: usize,
    at: bool,
) -> f64 {
    let before = |vertex: &SumVertex<T>| {
        let depth = f64::from(vertex.z);
        if at { depth <= z } else { depth < z }
    };
    let next = vertices.partition_point(before);
    let of = |vertex: &SumVertex<T>| vertex.value.as_ref()[channel];
    match (next.checked_sub(1).map(|last| &vertices[last]), vertices.get(next)) {
        (None, _) => 1.0,
        (Some(last), None) => of(last),
        (Some(last), Some(next)) => {
            let along = (z - f64::from(last.z)) / (f64::from(next.z) - f64::from(last.z));
            of(last) + along * (of(next) - of(last))
        }
    }
}

/// Depths that tell: those of both, between and beside them.
fn depths(exact: &[f32], stored: &[f32]) -> Vec<f32> {
    let mut depths: Vec<f32> = exact.iter().chain(stored).copied().collect();
    depths.sort_by(f32::total_cmp);
    let middles: Vec<f32> = depths.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let beside: Vec<f32> = depths.iter().flat_map(|z| [z.next_up(), z.next_down()]).collect();
    depths.extend(middles.into_iter().chain(beside));
    depths.retain(|&z| z > 0.0);
    depths
}

fn check_pixel<T: Transmittance>(
    exact: &[SumVertex<T>],
    stored: VisibilityView<'_, T>,
    epsilon: f64,
    delta: f64,
) -> Result<(), TestCaseError> {
    let exact_depths: Vec<f32> = exact.iter().map(|vertex| vertex.z).collect();
    for z in depths(&exact_depths, stored.depths()) {
        for channel in 0..T::CHANNELS {
            let z64 = f64::from(z);
            // Both sides of a step of the map: each within what the other allows.
            for (value_there, at) in [(stored.at(z), true), (stored.before(z), false)] {
                let answer = f64::from(value_there.channel(channel));
                let least = value::<T>(exact, z64, channel, at) - epsilon;
                let most = value::<T>(exact, z64 - delta, channel, false) + epsilon;
                prop_assert!(answer >= least - 1e-6, "{z} {at}: {answer} below {least}");
                prop_assert!(answer <= most + 1e-6, "{z} {at}: {answer} above {most}");
            }
        }
    }
    Ok(())
}

fn check<T: Transmittance>(
    scene: RandomScene,
    settings: &BakeSettings,
    depth_bits: u32,
    epsilon: f32,
) -> Result<(), TestCaseError> {
    let quantization = Quantization::new(depth_bits).unwrap();
    let tolerance = Tolerance::new(epsilon).unwrap();
    let mut settings = settings.clone();
    settings.tolerance = Some(tolerance);
    settings.quantization = Some(quantization);
    let baker = Baker::<T, _>::new(scene, settings.clone()).unwrap();
    // Curved pixels have less to spend, and finer grids.
    let step = f64::from(Quantization::value_step(tolerance.after(tolerance.chord())));
    for tile in settings.tiles() {
        let baked = baker.tile(tile).unwrap();
        prop_assert!(baked.max_error() <= f64::from(epsilon) + 1e-7, "{}", baked.max_error());
        let mut exact = Vec::new();
        let visit = |pixel: dsm_core::detail::ExactPixel<'_, T>| {
            exact.push((pixel.pixel(), pixel.vertices().to_vec()));
        };
        baker.exact_tile(tile, visit).unwrap();
        let first = tile.map(|index| index * settings.tile_size);
        for (pixel, vertices) in exact {
            let stored = baked.pixels().view();
            let stored = stored.pixel(pixel[0] - first[0], pixel[1] - first[1]);
            for vertex in stored.vertices() {
                prop_assert_eq!(quantization.snap(vertex.z), vertex.z);
                let steps = f64::from(vertex.value.channel(0)) / step;
                prop_assert_eq!(steps, steps.round());
            }
            let delta = f64::from(baked.depth_error());
            check_pixel(&vertices, stored, epsilon.into(), delta)?;
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(77))]

    #[test]
    fn rounded_maps_keep_their_bound(
        scene in scenes(),
        settings in settings(),
        depth_bits in 4_u32..24,
        epsilon in prop::sample::select(vec![0.125_f32, 0.0625, 0.01, 0.001, 1.0 / 65536.0]),
    ) {
        check::<f32>(scene, &settings, depth_bits, epsilon)?;
        check::<Rgb>(scene, &settings, depth_bits, epsilon)?;
    }
}

#[test]
fn what_cannot_be_rounded_is_refused() {
    let mut settings = BakeSettings::new([4, 4]).unwrap();
    settings.quantization = Some(Quantization::default());
    let scene = RandomScene { seed: 7, on_grid: false, media: 5, backwards: false };
    assert!(Baker::<f32, _>::new(scene, settings.clone()).is_ok());
    settings.tolerance = Some(Tolerance::EXACT);
    assert!(Baker::<f32, _>::new(scene, settings).is_err());
}

#[test]
fn a_ramp_stays_a_ramp() {
    // 256 samples within eight steps of the grid of depths.
    let source = RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
        let depth = (5.0 + 0.002 * point.x.fract()) as f32;
        ray.push_surface(SurfaceHit { depth, opacity: 1.0 })
    });
    let mut settings = BakeSettings::new([1, 1]).unwrap();
    settings.sampling = PixelSampling::new(256, 0).unwrap();
    // What the rounding of values leaves: an eighth of the tolerance is half their step.
    let least = Tolerance::new(0.875 * settings.tolerance().epsilon()).unwrap();
    let grids = [(None, Some(least)), (Some(Quantization::default()), None)];
    let [exact, rounded] = grids.map(|(quantization, tolerance)| {
        let settings = settings.clone().with_quantization(quantization).with_tolerance(tolerance);
        let tile = Baker::<f32, _>::new(&source, settings).unwrap().tile([0, 0]).unwrap();
        tile.pixels().view().vertex_count()
    });
    assert!(rounded <= exact + 2, "{rounded} instead of {exact}");
}
