//! T(z) = ∏ (1 − aᵢ(z)) for every pixel, straight from the samples in `f64`.

use dsm_core::{DeepMap, Rgb, Transmittance};
use dsm_io::deep_exr::{self, DeepExrReader, DeepRows};
use dsm_io::detail::AnyDeepMap;
use dsm_io::{Limits, MapReader};

use super::{IMAGES, converted, image, options};

/// The share of light that one sample stops in front of and at `z`.
fn opacity_at(z_front: f64, z_back: f64, alpha: f64, z: f64) -> f64 {
    if z_back <= z_front {
        return if z >= z_front { alpha } else { 0.0 };
    }
    let share = ((z - z_front) / (z_back - z_front)).clamp(0.0, 1.0);
    if alpha == 1.0 { f64::from(share > 0.0) } else { 1.0 - (1.0 - alpha).powf(share) }
}

pub(super) fn transmittance(rows: &DeepRows, pixel: usize, channel: usize, z: f32) -> f64 {
    rows.pixel(pixel)
        .map(|index| {
            let sample = rows.sample(index);
            let alpha = f64::from(sample.alpha[channel]);
            1.0 - opacity_at(sample.z.into(), sample.z_back.into(), alpha, z.into())
        })
        .product()
}

/// Every sample's own depths, their neighbours, halfway to the next and beyond.
fn depths(rows: &DeepRows, pixel: usize) -> Vec<f32> {
    let mut depths: Vec<f32> = rows
        .pixel(pixel)
        .flat_map(|index| [rows.sample(index).z, rows.sample(index).z_back])
        .collect();
    depths.sort_by(f32::total_cmp);
    let between: Vec<f32> = depths.windows(2).map(|pair| 0.5 * pair[0] + 0.5 * pair[1]).collect();
    let beside = depths.iter().flat_map(|z| [z.next_down(), z.next_up()]).collect::<Vec<_>>();
    depths.extend(between);
    depths.extend(beside);
    depths.extend([f32::MIN_POSITIVE, f32::MAX]);
    depths.retain(|&z| z > 0.0);
    depths
}

fn assert_within<T: Transmittance>(map: &DeepMap<T>, rows: &DeepRows, bound: f64, name: &str) {
    let mut asked = 0;
    for (pixel, function) in map.pixels().view().functions().enumerate() {
        for z in depths(rows, pixel) {
            for channel in 0..T::CHANNELS {
                let found = f64::from(function.at(z).channel(channel));
                let truth = transmittance(rows, pixel, channel, z);
                assert!(
                    (found - truth).abs() <= bound,
                    "{name}, pixel {pixel} at {z}, channel {channel}: {found} is not {truth}"
                );
                asked += 1;
            }
        }
    }
    assert!(asked > 0, "{name} has no samples to ask about");
}

#[test]
fn maps_answer_the_transmittance_of_their_samples() {
    let folder = tempfile::tempdir().unwrap();
    for name in IMAGES {
        let mut reader =
            DeepExrReader::open(&image(name), None, &deep_exr::Limits::default()).unwrap();
        let rows = reader.read_rows(0..reader.header().height).unwrap();
        for (epsilon, bound) in [(0.0, 1e-6), (0.005, 0.005), (0.1, 0.1)] {
            let path = converted(&image(name), folder.path(), &options(epsilon, 5));
            let reader = MapReader::open(&path, &Limits::default()).unwrap();
            assert!(reader.verify().is_empty(), "{name}: {:?}", reader.verify());
            match AnyDeepMap::read(&reader, 0).unwrap() {
                AnyDeepMap::Mono(map) => assert_within::<f32>(&map, &rows, bound, name),
                AnyDeepMap::Rgb(map) => assert_within::<Rgb>(&map, &rows, bound, name),
            }
        }
    }
}
