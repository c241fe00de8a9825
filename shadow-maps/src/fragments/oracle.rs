//! Tracing fragments as naively as can be, and what the tracer is compared
//! with.

use dsm_core::{AreaLight, LightVisibility, ShadedPoint, ShadowCamera, Transmittance};
use dsm_testkit::config;
use dsm_trace::detail::{LightFrame, TraceStatistics};
use fearless_simd::Level;
use glam::{DMat4, DVec3, DVec4};
use proptest::prelude::*;

use super::columns::FragmentColumns;
use super::fragment::Fragment;
use super::map::FragmentMap;
use super::tracer::{FragmentTracer, TraceScratch};

/// A camera at the origin that looks down −z, 90 degrees wide and high.
pub(crate) fn frame(size: [u32; 2], light_depth: f64) -> LightFrame {
    let to_ndc = DMat4::from_cols(
        DVec4::new(0.5, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -0.5, 0.0, 0.0),
        DVec4::new(-0.5, -0.5, -1.0, -1.0),
        DVec4::ZERO,
    );
    let camera =
        ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) };
    LightFrame::new(&camera, size, light_depth).unwrap()
}

/// A map of these fragments, pixel by pixel.
pub(crate) fn map<T: Transmittance>(
    frame: LightFrame,
    pixels: &[Vec<Fragment<T>>],
) -> FragmentMap<T> {
    let mut columns = FragmentColumns::new();
    for pixel in pixels {
        let mut pixel = pixel.clone();
        pixel.sort_by(|a, b| a.w.total_cmp(&b.w));
        columns.push_pixel(pixel).unwrap();
    }
    FragmentMap::new(frame, columns).unwrap()
}

/// Where rays start: for planes, and for what faces the camera.
pub(crate) const STARTS: [f64; 2] = [0.01, 0.3];

/// What is left of a ray's light after every fragment of every pixel, in `f64`;
/// `None` if some crossing is too close to an edge to be sure.
pub(crate) fn naive<T: Transmittance>(
    map: &FragmentMap<T>,
    receiver: DVec3,
    light: DVec3,
) -> Option<T::Sum> {
    let frame = map.frame();
    let mut left = T::CLEAR.to_sum();
    let Some(ray) = frame.ray(receiver, light, STARTS[0]) else { return Some(left) };
    let later = frame.ray(receiver, light, STARTS[1]).map_or(f64::INFINITY, |ray| ray.range()[0]);
    let [place_x, place_y] = ray.at(0.0);
    let [along_x, along_y] = ray.slope();
    let [width, height] = map.size();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let corner = [f64::from(x), f64::from(y)];
        for fragment in map.pixel(x, y) {
            let [gain_x, gain_y] = fragment.slope().map(f64::from);
            let closing = 1.0 - gain_x * along_x - gain_y * along_y;
            let w = f64::from(fragment.w)
                + gain_x * (place_x - corner[0] - 0.5)
                + gain_y * (place_y - corner[1] - 0.5);
            let w = w / closing;
            let within = [place_x + along_x * w - corner[0], place_y + along_y * w - corner[1]];
            let start = if fragment.is_facing() { later } else { ray.range()[0] };
            let end = ray.range()[1];
            let near = within.iter().all(|at| (-0.01..1.01).contains(at));
            if near {
                let on_edge = within.iter().any(|at| (at * 8.0 - (at * 8.0).round()).abs() < 4e-3);
                let at_end = (w - start).abs() < 1e-5 || (w - end).abs() < 1e-5;
                if on_edge || at_end || closing.abs() < 0.05 {
                    return None;
                }
            }
            if w >= start && w < end && fragment.covers(within) {
                for (channel, left) in left.as_mut().iter_mut().enumerate() {
                    *left *= 1.0 - f64::from(fragment.opacity.channel(channel));
                }
            }
        }
    }
    Some(left)
}

pub(crate) fn fragment() -> impl Strategy<Value = Fragment<f32>> {
    let slope = prop_oneof![Just(0.0_f32), -0.01_f32..0.01, -0.2_f32..0.2];
    let gradient = prop_oneof![
        1 => Just(None),
        3 => (slope.clone(), slope).prop_map(|(x, y)| Some([x, y])),
    ];
    let coverage = prop_oneof![
        Just(Fragment::<f32>::WHOLE),
        any::<u64>().prop_map(|bits| bits | 1),
        (0_u32..64).prop_map(|bit| 1 << bit),
    ];
    (0.1_f32..1.0, gradient, coverage).prop_map(|(w, gradient, coverage)| Fragment {
        w,
        gradient,
        opacity: 0.5,
        coverage,
    })
}

type Pixels = Vec<Vec<Fragment<f32>>>;

pub(crate) fn pixels() -> impl Strategy<Value = ([u32; 2], Pixels)> {
    // Wide maps of a few fragments, and narrow ones of hundreds a block.
    let size = prop_oneof![
        3 => (1_u32..40, 1_u32..40, Just(1..40)),
        1 => (1_u32..9, 1_u32..9, Just(20..60)),
    ];
    size.prop_flat_map(|(width, height, many)| {
        let few = if many.start == 1 { 1..3 } else { many.clone() };
        let pixel = prop_oneof![
            3 => Just(Vec::new()),
            3 => proptest::collection::vec(fragment(), few),
            1 => proptest::collection::vec(fragment(), many),
        ];
        let count = (width * height) as usize;
        (Just([width, height]), proptest::collection::vec(pixel, count))
    })
}

pub(crate) fn point(depths: std::ops::Range<f64>) -> impl Strategy<Value = DVec3> {
    (-1.2_f64..1.2, -1.2_f64..1.2, depths).prop_map(|(x, y, z)| DVec3::new(x * z, y * z, -z))
}

proptest! {
    #![proptest_config(config(21))]

    #[test]
    fn tracing_meets_what_every_pixel_holds((size, pixels) in pixels(),
        receiver in point(1.5..9.0), (x, y, depth) in (-1.0_f64..1.0, -1.0_f64..1.0, -0.3_f64..0.4),
        spread in prop_oneof![Just(1e-3), Just(0.05), Just(0.7)], count in 1_usize..40,
        opaque in any::<bool>())
    {
        let mut pixels = pixels;
        if opaque {
            // One hit ends a ray, and not its neighbours.
            pixels.iter_mut().flatten().for_each(|fragment| fragment.opacity = 1.0);
        }
        let map = map(frame(size, 0.25), &pixels);
        let tracer = FragmentTracer::new(map.clone()).unwrap().with_start(STARTS[0], STARTS[1]);
        let tracer = tracer.with_least_light(if opaque { 1e-3 } else { 0.0 });
        // A spiral of points.
        let lights: Vec<_> = (0..count).map(|at| {
            let (angle, radius) = (at as f64 * 2.4, spread * (at as f64 / count as f64).sqrt());
            let (sin, cos) = angle.sin_cos();
            DVec3::new(x + radius * cos, y + radius * sin, -depth)
        }).collect();
        let mut scratch = TraceScratch::default();
        let mut sum = 0.0;
        for &light in &lights {
            let alone = f64::from(tracer.mean(receiver, &[light], &mut scratch));
            if let Some([expected]) = naive(&map, receiver, light) {
                // Halves: one hit more or less shows.
                prop_assert_eq!(alone, expected);
            }
            sum += alone;
        }
        // 16 at a time, by the same numbers.
        let mean = f64::from(tracer.mean(receiver, &lights, &mut scratch));
        prop_assert!((mean - sum / count as f64).abs() <= 1e-6, "{} {}", mean, sum);
        // The same bits with other instructions.
        let best = Level::new();
        let levels = [best.as_avx2().map(Level::Avx2), Some(Level::baseline())];
        let mut tracer = tracer;
        for level in levels.into_iter().flatten() {
            tracer = tracer.with_level(level);
            prop_assert_eq!(f64::from(tracer.mean(receiver, &lights, &mut scratch)), mean);
        }
    }

    #[test]
    fn another_fragment_never_lightens((size, mut pixels) in pixels(), more in fragment(),
        receiver in point(1.5..9.0), at in any::<proptest::sample::Index>())
    {
        let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.4, DVec3::Y * 0.4);
        let means = [(); 2].map(|()| {
            let map = map(frame(size, 0.0), &pixels);
            let tracer = FragmentTracer::new(map.clone()).unwrap().with_rays(64);
            let at = at.index(pixels.len());
            pixels[at].push(more);
            tracer.visibility(receiver, &light, 3).unwrap()
        });
        prop_assert!(means[1] <= means[0]);
    }
}

/// Leaves smaller than a pixel all over a cube, the same every time.
fn leaves(size: u32) -> FragmentMap<f32> {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        f64::from(state >> 8) / 16_777_216.0
    };
    let mut pixels: Pixels = vec![Vec::new(); (size * size) as usize];
    for _ in 0..2 * size * size {
        let (x, y) = ((next() * f64::from(size)) as usize, (next() * f64::from(size)) as usize);
        let fragment = Fragment {
            w: 0.25 + 0.25 * next() as f32,
            gradient: Some([0.0; 2]),
            opacity: 0.5,
            coverage: u64::MAX >> (34.0 + next() * 24.0) as u32,
        };
        pixels[y * size as usize + x].push(fragment);
    }
    map(frame([size; 2], 0.0), &pixels)
}

/// An opaque wall across all pixels, at right angles to the view.
fn wall(size: u32) -> FragmentMap<f32> {
    let coverage = Fragment::<f32>::WHOLE;
    let pixels: Pixels = (0..size * size)
        .map(|pixel| {
            // A slope that connects all pixels.
            let w = 0.3 + 0.002 * (pixel % size) as f32;
            vec![Fragment { w, gradient: Some([0.002, 0.0]), opacity: 1.0, coverage }]
        })
        .collect();
    map(frame([size; 2], 0.0), &pixels)
}

#[test]
fn far_tables_serve_leaves_and_keep_walls() {
    let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5);
    let leaves = leaves(128);
    let exact = FragmentTracer::new(leaves.clone()).unwrap();
    let mixed = FragmentTracer::new(leaves.clone()).unwrap().for_light(&light);
    assert!(mixed.has_far_table());
    let mut worst: f32 = 0.0;
    for seed in 0..40_u64 {
        let x = seed as f64 / 40.0 - 0.5;
        let receiver = DVec3::new(x, x * 0.7, -4.5);
        let Ok(truth) = exact.visibility(receiver, &light, seed);
        let Ok(value) = mixed.visibility(receiver, &light, seed);
        worst = worst.max((truth - value).abs());
    }
    assert!(worst < 0.04 && worst > 0.0, "{worst}");
    // A wall stays one, which fine leaves before it do not change.
    let wall = wall(128);
    assert!(!FragmentTracer::new(wall.clone()).unwrap().with_far_table(1.0).has_far_table());
    let both: Pixels = (0..128 * 128)
        .map(|pixel| {
            let [x, y] = [pixel % 128, pixel / 128];
            wall.pixel(x, y).chain(leaves.pixel(x, y)).collect()
        })
        .collect();
    let mixed = FragmentTracer::new(map(frame([128; 2], 0.0), &both)).unwrap().with_far_table(1.0);
    assert!(mixed.has_far_table());
    for x in [-3.0, -1.5, 0.0, 1.0] {
        let Ok(value) = mixed.visibility(DVec3::new(x, 0.3, -3.5), &light, 1);
        assert_eq!(value, 0.0, "{x}");
    }
}

#[test]
fn far_tables_answer_alike_on_every_processor() {
    let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5);
    let leaves = leaves(64);
    let mut tracer = FragmentTracer::new(leaves.clone()).unwrap().with_far_table(1.0);
    let values = |tracer: &FragmentTracer<f32>| -> Vec<f32> {
        let receiver = |at: i32| DVec3::new(f64::from(at) * 0.1, 0.3, -4.2);
        (-30..30).map(|at| tracer.visibility(receiver(at), &light, 5).unwrap()).collect()
    };
    let best = values(&tracer);
    let all = [Level::new().as_avx2().map(Level::Avx2), Some(Level::baseline())];
    for level in all.into_iter().flatten() {
        tracer = tracer.with_level(level);
        assert_eq!(values(&tracer), best);
    }
    assert!(best.iter().any(|&value| value < 0.9));
}

#[test]
fn odd_receivers_and_lights_are_lit_and_counted() {
    let map = wall(16);
    let tracer = FragmentTracer::new(map.clone()).unwrap();
    let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5);
    let lit = [
        DVec3::ZERO,
        DVec3::Z,
        DVec3::NAN,
        DVec3::new(0.0, f64::INFINITY, -3.0),
        DVec3::splat(f64::MAX),
    ];
    for receiver in lit {
        assert_eq!(tracer.visibility(receiver, &light, 0), Ok(1.0), "{receiver}");
    }
    let beside = TraceStatistics { rays: 5 * 256, outside_map: 0, behind_light: 5 * 256 };
    assert_eq!(tracer.statistics(), beside);
    let behind = DVec3::new(0.0, 0.0, -5.0);
    assert_eq!(tracer.visibility(behind, &light, 0), Ok(0.0));
    let mut scratch = TraceScratch::default();
    assert_eq!(tracer.mean(behind, &[], &mut scratch), 1.0, "no rays");
    assert_eq!(tracer.mean(behind, &[DVec3::NAN], &mut scratch), 1.0);
    assert_eq!(tracer.mean(behind, &[behind], &mut scratch), 1.0);
    // A light larger than the scene: rays leave the map, and are lit there.
    let large = AreaLight::disk(DVec3::ZERO, DVec3::X * 100.0, DVec3::Y * 100.0);
    let Ok(value) = tracer.visibility(behind, &large, 0);
    assert!((0.0..=1.0).contains(&value));
    let statistics = tracer.statistics();
    assert!(statistics.outside_map > 200 && statistics.outside_map <= 256, "{statistics:?}");
    // No fragments at all.
    let empty = FragmentColumns { offsets: vec![0; 65], ..FragmentColumns::default() };
    let empty = FragmentMap::<f32>::new(frame([8, 8], 0.0), empty).unwrap();
    let tracer = FragmentTracer::new(empty.clone()).unwrap().for_light(&light);
    assert_eq!(tracer.visibility(behind, &light, 0), Ok(1.0));
    assert!(!tracer.has_far_table());
}

#[test]
fn many_points_are_answered_as_one_by_one() {
    let map = leaves(64);
    let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5);
    let tracer = FragmentTracer::new(map.clone()).unwrap().with_rays(48);
    let points: Vec<_> = (0..200_u64)
        .map(|seed| {
            let position = DVec3::new(seed as f64 * 0.02 - 2.0, 0.4, -3.5);
            ShadedPoint { position, facing: dsm_core::Facing::Light, seed }
        })
        .collect();
    let mut values = vec![0.25];
    tracer.visibilities(&points, &light, &mut values).unwrap();
    let expected = points.iter().map(|p| tracer.visibility(p.position, &light, p.seed).unwrap());
    assert!(values.iter().copied().eq(std::iter::once(0.25).chain(expected)));
}
