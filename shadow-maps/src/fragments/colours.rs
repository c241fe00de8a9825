//! Maps of coloured fragments: traced against the oracle, and built.

use dsm_core::{AreaLight, LightVisibility, Rgb, Transmittance};
use dsm_testkit::config;
use glam::DVec3;
use proptest::prelude::*;

use super::fragment::Fragment;
use super::map::FragmentMap;
use super::oracle::{STARTS, fragment, frame, map, naive, point};
use super::tracer::{FragmentTracer, TraceScratch};

/// Halves, so that one hit more or less of any channel shows; some channels are
/// clear, but not all.
fn colour() -> impl Strategy<Value = Rgb> {
    (1_usize..27).prop_map(|code| {
        let share = |digit: usize| [0.0, 0.5, 1.0][code / digit % 3];
        Rgb::new(share(1), share(3), share(9))
    })
}

fn pane() -> impl Strategy<Value = Fragment<Rgb>> {
    (fragment(), colour()).prop_map(|(mono, opacity)| {
        let Fragment { w, gradient, coverage, .. } = mono;
        Fragment { w, gradient, opacity, coverage }
    })
}

fn panes() -> impl Strategy<Value = ([u32; 2], Vec<Vec<Fragment<Rgb>>>)> {
    (1_u32..30, 1_u32..30).prop_flat_map(|(width, height)| {
        let pixel = prop_oneof![
            2 => Just(Vec::new()),
            3 => proptest::collection::vec(pane(), 1..4),
            1 => proptest::collection::vec(pane(), 10..20),
        ];
        let count = (width * height) as usize;
        (Just([width, height]), proptest::collection::vec(pixel, count))
    })
}

fn channels(colour: Rgb) -> [f64; 3] {
    [0, 1, 2].map(|channel| f64::from(colour.channel(channel)))
}

proptest! {
    #![proptest_config(config(31))]

    #[test]
    fn tracing_meets_what_every_pixel_holds_in_every_channel((size, pixels) in panes(),
        receiver in point(1.5..9.0), (x, y, depth) in (-1.0_f64..1.0, -1.0_f64..1.0, -0.3_f64..0.4),
        spread in prop_oneof![Just(1e-3), Just(0.05), Just(0.7)], count in 1_usize..40)
    {
        let map = map(frame(size, 0.25), &pixels);
        let tracer = FragmentTracer::new(map.clone()).unwrap().with_start(STARTS[0], STARTS[1]);
        let tracer = tracer.with_least_light(0.0);
        let lights: Vec<_> = (0..count).map(|at| {
            let (angle, radius) = (at as f64 * 2.4, spread * (at as f64 / count as f64).sqrt());
            let (sin, cos) = angle.sin_cos();
            DVec3::new(x + radius * cos, y + radius * sin, -depth)
        }).collect();
        let mut scratch = TraceScratch::default();
        let (mut sum, mut unsure) = ([0.0; 3], 0);
        for &light in &lights {
            let alone = channels(tracer.mean(receiver, &[light], &mut scratch));
            match naive(&map, receiver, light) {
                Some(expected) => prop_assert_eq!(alone, expected),
                None => unsure += 1,
            }
            (0..3).for_each(|channel| sum[channel] += alone[channel]);
        }
        // 16 at a time.
        let mean = channels(tracer.mean(receiver, &lights, &mut scratch));
        let room = f64::from(unsure) / count as f64 + 1e-6;
        for channel in 0..3 {
            let off = (mean[channel] - sum[channel] / count as f64).abs();
            prop_assert!(off <= room, "{:?} {:?}", mean, sum);
        }
    }
}

/// Leaves smaller than a pixel all over a cube: green ones, which keep red and blue light from
/// passing, and some of other colours.
fn leaves(size: u32) -> FragmentMap<Rgb> {
    let mut state = 7_u32;
    let mut next = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        f64::from(state >> 8) / 16_777_216.0
    };
    let mut pixels = vec![Vec::new(); (size * size) as usize];
    for leaf in 0..2 * size * size {
        let (x, y) = ((next() * f64::from(size)) as usize, (next() * f64::from(size)) as usize);
        let opacity = match leaf % 4 {
            0 => Rgb::new(0.0, 0.75, 0.25),
            _ => Rgb::new(0.75, 0.125, 0.5),
        };
        let coverage = u64::MAX >> (34.0 + next() * 24.0) as u32;
        let w = 0.25 + 0.25 * next() as f32;
        pixels[y * size as usize + x].push(Fragment {
            w,
            gradient: Some([0.0; 2]),
            opacity,
            coverage,
        });
    }
    map(frame([size; 2], 0.0), &pixels)
}

#[test]
fn far_tables_keep_colours_apart() {
    let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5);
    let leaves = leaves(128);
    let exact = FragmentTracer::new(leaves.clone()).unwrap();
    let mixed = FragmentTracer::new(leaves.clone()).unwrap().for_light(&light);
    assert!(mixed.has_far_table());
    let (mut worst, mut apart) = (0.0_f64, 0.0_f64);
    for seed in 0..40_u64 {
        let x = seed as f64 / 40.0 - 0.5;
        let receiver = DVec3::new(x, x * 0.7, -4.5);
        let Ok(truth) = exact.visibility(receiver, &light, seed);
        let Ok(value) = mixed.visibility(receiver, &light, seed);
        let (truth, value) = (channels(truth), channels(value));
        for channel in 0..3 {
            worst = worst.max((truth[channel] - value[channel]).abs());
        }
        apart = apart.max((truth[0] - truth[1]).abs());
    }
    assert!(worst < 0.05 && worst > 0.0, "{worst}");
    assert!(apart > 0.1, "{apart}");
}
