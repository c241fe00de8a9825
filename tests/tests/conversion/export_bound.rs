//! The light that exported samples let through is the map's, at every depth.

use std::path::Path;

use dsm_core::detail::{PixelLists, PixelWindow, VisibilityView};
use dsm_core::{
    DeepMap, MapInfo, PixelListsBuilder, Progress, Rgb, Tolerance, Transmittance, Vertex,
};
use dsm_io::deep_exr::{self, Compression, DeepExrReader, DeepRows, Layout, SampleType, Window};
use dsm_io::{
    AchievedError, ExportOptions, ExportReport, Metadata, WriteOptions, export_deep_exr, write_map,
};
use dsm_testkit::config;
use proptest::collection::vec;
use proptest::prelude::*;

use super::accuracy::transmittance;
use super::open;

/// The largest difference that rounding opacities to 16 bits may make.
const HALF: f64 = 1.0 / 2048.0;

/// Fractions of what is left: none, all, nearly all, a bit, any.
fn fall() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(0.0_f32),
        Just(1.0),
        (1_u32..30).prop_map(|power| 1.0 - 0.5_f32.powi(power as i32)),
        (1_u32..40).prop_map(|power| 0.5_f32.powi(power as i32)),
        0.0_f32..1.0,
    ]
}

/// What stands between two vertices: a step, neighbouring depths, a ramp.
fn gap() -> impl Strategy<Value = Option<f32>> {
    prop_oneof![Just(None), Just(Some(0.0)), (0.001_f32..10.0).prop_map(Some)]
}

/// Falls from one vertex to the next, with the gaps between them.
fn pixel<T: Transmittance>() -> impl Strategy<Value = Vec<Vertex<T>>> {
    let start = prop_oneof![Just(0.0_f32), 0.1_f32..100.0];
    (start, vec((gap(), vec(fall(), 3)), 0..8)).prop_map(|(start, falls)| {
        if falls.is_empty() {
            return Vec::new();
        }
        let mut vertices = vec![Vertex::new(start, T::CLEAR)];
        for (gap, falls) in falls {
            let last = vertices[vertices.len() - 1];
            let value = T::from_channels(|c| last.value.channel(c) * (1.0 - falls[c]));
            let is_step = vertices.len() > 1 && vertices[vertices.len() - 2].z == last.z;
            let z = match gap {
                None if !is_step => last.z,
                None | Some(0.0) => last.z.next_up(),
                Some(gap) => (last.z + gap).max(last.z.next_up()),
            };
            vertices.push(Vertex::new(z, value));
        }
        vertices
    })
}

fn pixels<T: Transmittance>() -> impl Strategy<Value = PixelLists<T>> {
    (1_u32..6, 1_u32..6).prop_flat_map(|(width, height)| {
        vec(prop_oneof![Just(Vec::new()), pixel::<T>()], (width * height) as usize).prop_map(
            move |pixels| {
                let mut lists = PixelListsBuilder::new(width, height);
                for vertices in pixels {
                    vertices.into_iter().for_each(|vertex| lists.push(vertex));
                    lists.finish_pixel().unwrap();
                }
                lists.finish().unwrap()
            },
        )
    })
}

fn options() -> impl Strategy<Value = ExportOptions> {
    let layout = prop_oneof![
        Just(Layout::ScanLines),
        (1_u32..8).prop_map(|size| Layout::Tiles { width: size, height: size })
    ];
    let sample_type = prop_oneof![Just(SampleType::Float), Just(SampleType::Half)];
    let compression =
        prop_oneof![Just(Compression::Zips), Just(Compression::Rle), Just(Compression::None)];
    let error = prop_oneof![Just(1e-6_f32), Just(1e-5), Just(1e-3), Just(0.2)];
    (layout, sample_type, compression, error).prop_map(|(layout, sample_type, compression, e)| {
        ExportOptions {
            layout,
            sample_type,
            compression,
            error: Tolerance::new(e).unwrap(),
            ..ExportOptions::default()
        }
    })
}

/// The limit from the light's side of what samples let through at `z`.
fn transmittance_before(rows: &DeepRows, pixel: usize, channel: usize, z: f32) -> f64 {
    let left = |index| {
        let sample = rows.sample(index);
        let alpha = f64::from(sample.alpha[channel]);
        if sample.z_back <= sample.z {
            return if z > sample.z { 1.0 - alpha } else { 1.0 };
        }
        let (front, back) = (f64::from(sample.z), f64::from(sample.z_back));
        let share = ((f64::from(z) - front) / (back - front)).clamp(0.0, 1.0);
        (1.0 - alpha).powf(share)
    };
    rows.pixel(pixel).map(left).product()
}

/// The largest difference at both sides of all vertices, and between.
fn largest_difference<T: Transmittance>(
    view: VisibilityView<'_, T>,
    rows: &DeepRows,
    pixel: usize,
) -> f64 {
    // Long lists are looked at here and there.
    const LOOKS: usize = 40;
    let stride = |count: usize| count / LOOKS + 1;
    let mut depths: Vec<f32> = view.depths().iter().step_by(stride(view.len())).copied().collect();
    for pair in view.depths().windows(2).step_by(stride(view.len())) {
        for share in [1e-3, 0.02, 0.1, 0.25, 0.5, 0.7, 0.85, 0.98] {
            depths.push(pair[0] + (pair[1] - pair[0]) * share);
        }
    }
    let own = rows.pixel(pixel);
    for volume in own.clone().step_by(stride(own.len())).map(|index| rows.sample(index)) {
        depths.extend([0.25, 0.5, 0.75, 1.0].map(|s| volume.z + (volume.z_back - volume.z) * s));
    }
    depths.push(f32::MAX);
    let mut largest = 0.0_f64;
    for z in depths {
        for channel in 0..T::CHANNELS {
            let at = transmittance(rows, pixel, channel, z);
            let before = transmittance_before(rows, pixel, channel, z);
            largest = largest
                .max((at - f64::from(view.at(z).channel(channel))).abs())
                .max((before - f64::from(view.before(z).channel(channel))).abs());
        }
    }
    largest
}

fn assert_tidy<T: Transmittance>(view: VisibilityView<'_, T>, rows: &DeepRows, pixel: usize) {
    let samples: Vec<_> = rows.pixel(pixel).map(|index| rows.sample(index)).collect();
    for pair in samples.windows(2) {
        assert!(pair[0].z_back <= pair[1].z, "{pair:?}");
    }
    for sample in &samples {
        assert!(sample.z <= sample.z_back, "{sample:?}");
        let opaque = sample.alpha[..T::CHANNELS].contains(&1.0);
        assert!(!opaque || sample.z == sample.z_back, "an opaque volume: {sample:?}");
    }
    for channel in 0..T::CHANNELS {
        let left = transmittance(rows, pixel, channel, f32::INFINITY);
        let leaks = left > 0.0 && view.last().channel(channel) == 0.0;
        assert!(!leaks, "{left} is left where nothing is");
    }
}

fn export<T: Transmittance>(
    pixels: &PixelLists<T>,
    options: &ExportOptions,
    folder: &Path,
) -> (ExportReport, DeepExrReader) {
    let (width, height) = (pixels.view().width(), pixels.view().height());
    let min = [-3, -2];
    let data_window =
        PixelWindow { min, max: [min[0] + width as i32 - 1, min[1] + height as i32 - 1] };
    let info = MapInfo::new().with_data_window(data_window);
    let metadata = Metadata::new(width, height, T::CHANNELS as u8, info);
    let map = DeepMap::new(info, pixels.clone());
    let (input, output) = (folder.join("map.dsm"), folder.join("image.exr"));
    let write = WriteOptions::default().with_tile_size(4);
    write_map(&input, metadata, &map, AchievedError::NONE, write).unwrap();
    let report = export_deep_exr(&mut open(&input), &output, options, Progress::ignore).unwrap();
    let reader = DeepExrReader::open(&output, None, &deep_exr::Limits::default()).unwrap();
    let Window { min, max } = reader.header().data_window;
    assert_eq!(PixelWindow { min, max }, data_window);
    (report, reader)
}

fn check<T: Transmittance>(pixels: &PixelLists<T>, options: &ExportOptions) {
    let folder = tempfile::tempdir().unwrap();
    let (report, mut reader) = export(pixels, options, folder.path());
    let rows = reader.read_rows(0..pixels.view().height()).unwrap();
    assert_eq!(report.samples, rows.sample_count() as u64);
    assert_eq!(reader.header().stated_max_samples, Some(report.max_samples));
    let stated = f64::from(options.error.epsilon());
    let allowed = match options.sample_type {
        SampleType::Float => stated,
        SampleType::Half => stated + HALF,
    };
    assert!(report.achieved <= allowed, "{} of {allowed}", report.achieved);
    assert_eq!(report.total, report.achieved.max(stated));
    for (pixel, view) in pixels.view().functions().enumerate() {
        let difference = largest_difference(view, &rows, pixel);
        // The map's own answers are rounded to 32 bits.
        assert!(difference <= report.achieved + 7e-8, "{difference}, {}", report.achieved);
        assert_tidy(view, &rows, pixel);
    }
}

proptest! {
    #![proptest_config(config(0xe71_0e8a))]

    #[test]
    fn mono_maps(pixels in pixels::<f32>(), options in options()) {
        check(&pixels, &options);
    }

    #[test]
    fn coloured_maps(pixels in pixels::<Rgb>(), options in options()) {
        check(&pixels, &options);
    }
}

fn one_pixel(vertices: impl IntoIterator<Item = (f32, f32)>) -> PixelLists<f32> {
    let mut pixels = PixelListsBuilder::new(1, 1);
    vertices.into_iter().for_each(|(z, value)| pixels.push(Vertex::new(z, value)));
    pixels.finish_pixel().unwrap();
    pixels.finish().unwrap()
}

#[test]
fn a_ramp_from_1_to_0_keeps_its_bound_in_few_samples() {
    for (epsilon, most) in [(1e-6, 760), (1e-5, 250), (1e-3, 28), (0.1, 6)] {
        let pixels = one_pixel([(1.0, 1.0), (3.0, 0.0)]);
        for sample_type in [SampleType::Float, SampleType::Half] {
            let options = ExportOptions {
                error: Tolerance::new(epsilon).unwrap(),
                sample_type,
                ..ExportOptions::default()
            };
            let folder = tempfile::tempdir().unwrap();
            let (report, _) = export(&pixels, &options, folder.path());
            // Half opacities leave ramps half of a small error.
            let most = if sample_type == SampleType::Half { 3 * most / 2 } else { most };
            assert!((2..most).contains(&report.max_samples), "{epsilon}: {report:?}");
            check(&pixels, &options);
        }
    }
}

/// Rounding must not add up: each of these steps is rounded.
#[test]
fn thousands_of_steps_stay_within_the_error() {
    let steps = (0..6000_u16).flat_map(|step| {
        let (z, share) = (1.0 + f32::from(step), 0.9993_f32);
        [(z, share.powi(step.into())), (z, share.powi(i32::from(step) + 1))]
    });
    let pixels = one_pixel(steps);
    for (sample_type, most) in [(SampleType::Float, 7e-8), (SampleType::Half, 1e-6)] {
        let options = ExportOptions { sample_type, ..ExportOptions::default() };
        let folder = tempfile::tempdir().unwrap();
        let (report, _) = export(&pixels, &options, folder.path());
        assert!(report.max_samples > 5900, "{report:?}");
        assert!(report.achieved <= most, "{report:?}");
        check(&pixels, &options);
    }
}
