//! Media traced as naively as can be, and what the tracer is compared with: the slabs of
//! every pixel, and the media that these stand for.

use dsm_core::{
    AreaLight, Error, LightVisibility, Progress, RayHits, RaySource, Rgb, SamplePoint,
    ShadowCamera, SurfaceHit, Tolerance, Transmittance, VolumeSample,
};
use dsm_testkit::config;
use dsm_trace::detail::walk_every_pixel;
use fearless_simd::Level;
use glam::{DMat4, DVec3, DVec4};
use proptest::prelude::*;

use super::super::builder::FragmentBuilder;
use super::super::columns::FragmentColumns;
use super::super::fragment::Fragment;
use super::super::map::FragmentMap;
use super::super::oracle::{STARTS, fragment, frame, map, naive as naive_fragments, point};
use super::super::tracer::{FragmentTracer, TraceScratch};
use super::columns::MediaColumns;

/// The optical depth along a ray, pixel by pixel and slab by slab in `f64`.
fn naive<T: Transmittance>(map: &FragmentMap<T>, receiver: DVec3, light: DVec3) -> T::Sum {
    let mut sum = T::splat(0.0).to_sum();
    let (Some(media), Some(ray)) = (map.media(), map.frame().ray(receiver, light, 0.0)) else {
        return sum;
    };
    let away = map.frame().camera_point(light) - map.frame().camera_point(receiver);
    let stretch = away.length() / away.z.abs();
    let width = map.size()[0];
    walk_every_pixel(map.size(), &ray, &mut |[x, y]: [u32; 2], enter: f64, leave: f64| {
        let borders: Vec<_> = media.pixel((y * width + x) as usize).collect();
        for pair in borders.windows(2) {
            let [near, far] = [pair[0].0, pair[1].0].map(f64::from);
            let deep = (far.min(enter.recip()) - near.max(leave.recip())).max(0.0);
            for (channel, sum) in sum.as_mut().iter_mut().enumerate() {
                *sum += f64::from(pair[1].1.channel(channel)) * deep / (far - near) * stretch;
            }
        }
        std::ops::ControlFlow::Continue(())
    });
    sum
}

type Slabs = Vec<(f32, f32)>;

fn slabs() -> impl Strategy<Value = Slabs> {
    let thickness = prop_oneof![Just(0.0_f32), 0.0_f32..0.3, 0.0_f32..4.0];
    let all = proptest::collection::vec((0.01_f32..2.0, thickness), 1..6);
    (0.5_f32..6.0, all, 0.01_f32..1.0).prop_map(|(first, more, last)| {
        let mut depth = first;
        let mut slabs = vec![(first, 0.0)];
        for (length, thickness) in more {
            depth += length;
            slabs.push((depth, thickness));
        }
        slabs.push((depth + 0.25, last));
        slabs
    })
}

type Pixel = (Vec<Fragment<f32>>, Slabs);

fn pixels() -> impl Strategy<Value = ([u32; 2], Vec<Pixel>)> {
    (1_u32..24, 1_u32..24).prop_flat_map(|(width, height)| {
        let surfaces = prop_oneof![
            6 => Just(Vec::new()),
            1 => proptest::collection::vec(fragment(), 1..3),
        ];
        let media = prop_oneof![2 => Just(Vec::new()), 3 => slabs()];
        let count = (width * height) as usize;
        (Just([width, height]), proptest::collection::vec((surfaces, media), count))
    })
}

proptest! {
    #![proptest_config(config(41))]

    #[test]
    fn rays_pass_the_slabs_of_every_pixel((size, pixels) in pixels(), receiver in point(1.5..9.0),
        (x, y, depth) in (-1.0_f64..1.0, -1.0_f64..1.0, -0.3_f64..0.4), count in 1_usize..40)
    {
        let surfaces: Vec<_> = pixels.iter().map(|(surfaces, _)| surfaces.clone()).collect();
        let mut media = MediaColumns::new();
        pixels.iter().for_each(|(_, media_of)| media.push_pixel(media_of.clone()).unwrap());
        let map = map(frame(size, 0.25), &surfaces).with_media(media).unwrap();
        let tracer = FragmentTracer::new(map.clone()).unwrap().with_start(STARTS[0], STARTS[1]);
        let tracer = tracer.with_least_light(0.0);
        let lights: Vec<_> = (0..count).map(|at| {
            let (sin, cos) = (at as f64 * 2.4).sin_cos();
            let radius = 0.4 * (at as f64 / count as f64).sqrt();
            DVec3::new(x + radius * cos, y + radius * sin, -depth)
        }).collect();
        let mut scratch = TraceScratch::default();
        let mut sum = 0.0;
        for &light in &lights {
            let alone = f64::from(tracer.mean(receiver, &[light], &mut scratch));
            if let Some([expected]) = naive_fragments(&map, receiver, light) {
                let expected = expected * (-naive(&map, receiver, light)[0]).exp();
                prop_assert!((alone - expected).abs() < 1e-5, "{} {}", alone, expected);
            }
            sum += alone;
        }
        // 16 at a time, by the same numbers, and the same bits with other instructions.
        let mean = f64::from(tracer.mean(receiver, &lights, &mut scratch));
        prop_assert!((mean - sum / count as f64).abs() <= 1e-6, "{} {}", mean, sum);
        let best = Level::new();
        let levels = [best.as_avx2().map(Level::Avx2), Some(Level::baseline())];
        let mut tracer = tracer;
        for level in levels.into_iter().flatten() {
            tracer = tracer.with_level(level);
            prop_assert_eq!(f64::from(tracer.mean(receiver, &lights, &mut scratch)), mean);
        }
    }
}

/// At the origin, looking down −z, 90 degrees wide and high.
fn camera() -> ShadowCamera {
    let to_ndc = DMat4::from_cols(
        DVec4::new(0.5, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -0.5, 0.0, 0.0),
        DVec4::new(-0.5, -0.5, -1.0, -1.0),
        DVec4::ZERO,
    );
    ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) }
}

/// A cloud around (0.3, 0, −3), and fog that grows from depth 4 to 5; red takes half.
fn extinction(at: DVec3) -> f64 {
    let cloud = 5.0 * (-at.distance_squared(DVec3::new(0.3, 0.0, -3.0)) / 0.18).exp();
    cloud + (-4.0 - at.z).clamp(0.0, 1.0) * 0.5
}

const SIZE: u32 = 64;

/// The medium, behind it an opaque wall at depth 5.5, and before half of that another.
fn source<T: Transmittance>(
    size: u32,
) -> RaySource<impl Fn(SamplePoint, &mut RayHits<T>) -> Result<(), Error>> {
    RaySource(move |point: SamplePoint, hits: &mut RayHits<T>| {
        let [x, y] = [point.x, -point.y].map(|at| 2.0 * at / f64::from(size));
        let along = DVec3::new(x - 1.0, y + 1.0, -1.0);
        let samples = (0..=640_u16).map(|step| {
            let depth = 1.0 + f32::from(step) / 160.0;
            let value = extinction(along * f64::from(depth)) as f32;
            let of = |channel| if channel == 0 && T::CHANNELS == 3 { value / 2.0 } else { value };
            VolumeSample { depth, extinction: T::from_channels(of) }
        });
        hits.push_volume(&samples.collect::<Vec<_>>(), point.distance_per_depth)?;
        let opacity = T::splat(1.0);
        hits.push_surface(SurfaceHit { depth: 5.5, opacity })?;
        if point.x > f64::from(size / 2) {
            hits.push_surface(SurfaceHit { depth: 5.25, opacity })?;
        }
        Ok(())
    })
}

/// The optical depth between two points, by 1,500 steps through the medium itself.
fn truth(receiver: DVec3, light: DVec3) -> f64 {
    let steps = 1500;
    let at = |step: i32| receiver.lerp(light, (f64::from(step) + 0.5) / f64::from(steps));
    let inside = |at: &DVec3| at.z < -1.0 && at.z > -5.0;
    let sum: f64 = (0..steps).map(at).filter(inside).map(extinction).sum();
    sum * receiver.distance(light) / f64::from(steps)
}

/// Before the walls, in the medium, beside it and behind it.
fn receivers() -> impl Iterator<Item = DVec3> {
    (0..120_u32).map(|at| {
        let share = |factor: f64| (f64::from(at) * factor).fract();
        let depth = 1.5 + 3.7 * share(0.618_034);
        let [x, y] = [0.414_214, 0.732_051].map(|factor| 0.7 * depth * (2.0 * share(factor) - 1.0));
        DVec3::new(x, y, -depth)
    })
}

/// The largest difference to the truth, and at the root mean square, of rays to three lights.
fn off(size: u32, tolerance: f32) -> [f64; 2] {
    let tolerance = Tolerance::new(tolerance).unwrap();
    let builder = FragmentBuilder::new(camera(), [size; 2], 0.25).unwrap();
    let builder = builder.with_tolerance(tolerance);
    let built = builder.build_counted::<f32, _>(&source(size), Progress::ignore);
    let (map, counts) = built.unwrap().unwrap();
    let stated = counts.media_errors.iter().copied().fold(0.0, f32::max);
    // 256 slabs do not follow it for nothing.
    assert!(stated <= tolerance.epsilon().max(3e-4), "{stated}");
    let tracer = FragmentTracer::new(map).unwrap().with_least_light(0.0);
    let mut scratch = TraceScratch::default();
    let lights = [(0.0, 0.0), (0.3, -0.2), (-0.25, 0.1)].map(|(x, y)| DVec3::new(x, y, -0.25));
    let (mut most, mut square) = (0.0_f64, 0.0);
    for (receiver, light) in receivers().flat_map(|at| lights.map(|light| (at, light))) {
        let have = f64::from(tracer.mean(receiver, &[light], &mut scratch));
        let difference = have - (-truth(receiver, light)).exp();
        most = most.max(difference.abs());
        square += difference * difference / 360.0;
    }
    [most, square.sqrt()]
}

#[test]
fn slabs_stand_for_the_media_themselves() {
    // At the cloud, whose radius is 0.3, a pixel is 0.19 wide, 0.09 and 0.05.
    let [coarse, middle, fine] = [32, 64, 128].map(|size| off(size, 0.005));
    assert!(fine[0] < 0.04 && fine[1] < 0.005, "{coarse:?} {middle:?} {fine:?}");
    assert!(fine[1] < 0.35 * coarse[1], "{coarse:?} {middle:?} {fine:?}");
    let (exact, loose) = (off(64, 0.0), off(64, 0.1));
    assert!(exact[1] < 1.01 * middle[1] && loose[1] > 2.0 * middle[1], "{exact:?} {loose:?}");
    assert!(loose[0] < 0.2, "{loose:?}");
}

#[test]
fn stated_errors_bound_what_slabs_do_to_the_ray_of_a_pixel() {
    let builder = FragmentBuilder::new(camera(), [SIZE; 2], 0.0).unwrap();
    let builder = builder.with_tolerance(Tolerance::new(0.05).unwrap());
    let (map, counts) =
        builder.build_counted::<Rgb, _>(&source(SIZE), Progress::ignore).unwrap().unwrap();
    let mut found = [0.0_f64; 2];
    for pixel in [300_usize, 2088, 2100, 2500, 4000] {
        let [x, y] = [pixel as u32 % SIZE, pixel as u32 / SIZE].map(|at| f64::from(at) + 0.5);
        let stated = f64::from(counts.media_errors[pixel]);
        assert!(stated > 0.0 && stated <= 0.05, "{stated}");
        for step in 1..500 {
            let receiver = map.frame().unproject(x, y, f64::from(step) / 100.0);
            let have = naive(&map, receiver, DVec3::ZERO).map(|depth| (-depth).exp());
            let want = truth(receiver, DVec3::ZERO);
            // Between samples of the medium lie chords.
            for (channel, share) in [(0, 0.5), (1, 1.0)] {
                let off = (have[channel] - (-share * want).exp()).abs();
                assert!(off <= stated + 3e-4, "{pixel} {step}: {off} {stated}");
                found[channel] = found[channel].max(off);
            }
        }
    }
    assert!(found.iter().all(|off| *off > 0.004), "{found:?}");
}

#[test]
fn media_dim_what_surfaces_let_through() {
    let builder = FragmentBuilder::new(camera(), [SIZE; 2], 0.25).unwrap();
    let light = AreaLight::rectangle(DVec3::Z * -0.25, DVec3::X * 0.2, DVec3::Y * 0.2);
    let both = FragmentTracer::<Rgb>::new(builder.build(&source(SIZE)).unwrap()).unwrap();
    // Between the walls, on the right side and on the left.
    let Ok(dark) = both.visibility(DVec3::new(1.0, 0.0, -5.4), &light, 1);
    assert_eq!(dark, Rgb::splat(0.0));
    let Ok(lit) = both.visibility(DVec3::new(-1.0, 0.0, -5.4), &light, 1);
    assert!(lit.red > lit.green + 0.05 && lit.green == lit.blue && lit.green > 0.5, "{lit:?}");
    assert_eq!(both.visibility(DVec3::new(-1.0, 0.0, -5.6), &light, 1), Ok(Rgb::splat(0.0)));
}

#[test]
fn what_lies_before_the_light_does_not_count() {
    // The light in the middle of the fog, and the camera before it.
    let builder = FragmentBuilder::new(camera(), [SIZE; 2], 4.5).unwrap();
    let map = builder.build::<f32, _>(&source(SIZE)).unwrap();
    let [near, far] = map.media().unwrap().range().unwrap();
    assert_eq!([near, far], [4.5, 5.0]);
}

#[test]
fn a_map_of_media_alone_is_traced() {
    let mut media = MediaColumns::new();
    (0..64).for_each(|_| media.push_pixel([(2.0_f32, 0.0_f32), (3.0, 0.7)]).unwrap());
    let mut columns = FragmentColumns::new();
    (0..64).for_each(|_| columns.push_pixel([]).unwrap());
    let map = FragmentMap::new(frame([8; 2], 0.0), columns).unwrap().with_media(media).unwrap();
    let light = AreaLight::point(DVec3::ZERO);
    let tracer = FragmentTracer::new(map).unwrap().for_light(&light);
    for (depth, left) in [(1.5, 0.0), (2.5, 0.35), (4.0, 0.7)] {
        let Ok(value) = tracer.visibility(DVec3::Z * -depth, &light, 0);
        assert!((f64::from(value) - f64::exp(-left)).abs() < 1e-6, "{depth}: {value}");
    }
    // Aslant: as far as the diagonal goes.
    let Ok(value) = tracer.visibility(DVec3::new(-4.0, 0.0, -4.0), &light, 0);
    assert!((f64::from(value) - f64::exp(-0.7 * f64::sqrt(2.0))).abs() < 1e-6, "{value}");
    assert_eq!(tracer.visibility(DVec3::NAN, &light, 0), Ok(1.0));
}
