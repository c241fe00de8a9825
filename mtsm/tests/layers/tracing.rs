//! Shadow rays through maps of layers.

use std::fmt::Debug;
use std::sync::Arc;

use dsm_core::{
    AreaLight, Error, Facing, LightVisibility, OcclusionTracer, Rgb, ShadedPoint, ShadowCamera,
    Transmittance, VisibilityField,
};
use dsm_testkit::config;
use glam::DVec3;
use mtsm::MultilayerMap;
use mtsm::detail::{LayeredInfo, LeafRule, MultilayerTracer, TraceSettings, TracedMap};
use proptest::prelude::*;

use crate::views::{Sheets, sheets};

fn settings(rule: LeafRule, depth_threshold: f64, start: f64) -> TraceSettings {
    TraceSettings {
        rule,
        depth_threshold,
        start: Some(start),
        stop_below: 0.0,
        ..TraceSettings::default()
    }
}

/// Places in the view and beside it, some at depths of layers.
fn receiver() -> impl Strategy<Value = DVec3> {
    let side = (-12_i8..13).prop_map(|at| f64::from(at) / 8.0);
    let depth = (1_u8..40).prop_map(|at| f64::from(at) / 4.0);
    (side.clone(), side, depth).prop_map(|(x, y, z)| DVec3::new(x * z, y * z, -z))
}

/// Points of a large light at `depth`.
fn light_point(depth: f64) -> impl Strategy<Value = DVec3> {
    let side = (-8_i8..9).prop_map(|at| f64::from(at) / 4.0);
    (side.clone(), side).prop_map(move |(x, y)| DVec3::new(x, y, -depth))
}

fn check_walk<M: TracedMap>(map: M, rays: &[(DVec3, DVec3)]) {
    let map = Arc::new(map);
    for rule in [LeafRule::Ratio, LeafRule::Subtract] {
        for threshold in [0.0, 0.3] {
            let tracer =
                MultilayerTracer::new(Arc::clone(&map), settings(rule, threshold, 0.0)).unwrap();
            for &(receiver, light) in rays {
                let traced = tracer.transmittance(receiver, light, 0.5).unwrap();
                let naive = tracer.transmittance_naively(receiver, light).unwrap();
                assert_eq!(traced, naive, "{rule:?} {threshold} {receiver} {light}");
            }
        }
    }
}

fn check_walks<T: Transmittance>(sheets: &Sheets, light_depth: f32, rays: &[(DVec3, DVec3)]) {
    let baker = sheets.baker::<T>(0.05, light_depth);
    check_walk(baker.map().unwrap(), rays);
    if sheets.samples == 1 {
        check_walk(baker.depth_map().unwrap(), rays);
    }
}

/// How much light the tracer finds left of a light without size at the camera.
fn check_point<T: Transmittance>(sheets: &Sheets, tolerance: f32, receiver: DVec3) {
    let map = sheets.baker::<T>(tolerance, 0.0).map().unwrap();
    for rule in [LeafRule::Ratio, LeafRule::Subtract] {
        let tracer =
            MultilayerTracer::new(Arc::new(map.clone()), settings(rule, 0.0, 0.0)).unwrap();
        let Some(place) = tracer.frame().project(receiver) else { continue };
        let size = VisibilityField::size(&map).map(f64::from);
        if !(0..2).all(|axis| (0.0..size[axis]).contains(&place[axis])) {
            continue;
        }
        let [x, y] = [place.x as u32, place.y as u32];
        let looked_up = map.evaluate([x, y], -receiver.z as f32).unwrap();
        let light = AreaLight::point(DVec3::ZERO);
        let traced = tracer.visibility(receiver, &light, 1).unwrap();
        let runs = map.pixels().runs((y * 7 + x) as usize);
        let falls = runs.flat_map(|run| {
            let values: Vec<T> = run.layers().map(|layer| layer.visibility).collect();
            values.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()
        });
        let falls: Vec<[T; 2]> = falls.collect();
        for channel in 0..T::CHANNELS {
            let fall = |[from, to]: &[T; 2]| from.channel(channel) - to.channel(channel);
            let largest = falls.iter().map(fall).fold(0.0, f32::max);
            let difference = (traced.channel(channel) - looked_up.channel(channel)).abs();
            assert!(
                difference <= tolerance + largest + 1e-6,
                "{rule:?}: traced {traced:?}, looked up {looked_up:?}, largest step {largest}"
            );
        }
    }
}

/// Whether a ray tells where it is blocked, on its way, exactly where it loses light.
fn check_occlusion<O: OcclusionTracer<Error: Debug>>(tracer: &O, receiver: DVec3, light: DVec3) {
    let point = ShadedPoint { position: receiver, facing: Facing::Light, seed: 0 };
    let mut found = Vec::new();
    tracer.occlusions(&point, &[(light, 0.0)], &mut found).unwrap();
    let alone = tracer.transmittance(receiver, light, 0.0).unwrap();
    assert_eq!(found[0].transmittance, alone);
    assert_eq!(found[0].blocker.is_some(), alone != Transmittance::CLEAR);
    if let Some(blocker) = found[0].blocker {
        let way = light - receiver;
        let along = (blocker - receiver).dot(way) / way.length_squared();
        assert!((0.0..=1.0).contains(&along), "{receiver} {light}: {along}");
        let off = blocker.distance(receiver + way * along);
        assert!(off <= 1e-9 * (receiver.length() + light.length()), "{off}");
    }
}

/// Whether any more light gets through once there is another sheet.
fn check_occluder<T: Transmittance>(
    sheets: &Sheets,
    more: (usize, f32, f32),
    rays: &[(DVec3, DVec3)],
) {
    let (pixel, depth, shade) = more;
    let mut shaded = sheets.clone();
    shaded.pixels[pixel].push((depth, shade));
    let [before, after] = [sheets, &shaded].map(|sheets| sheets.baker::<T>(0.0, 0.0));
    let maps = [before.map().unwrap(), after.map().unwrap()];
    let layers = [before.depth_map().unwrap(), after.depth_map().unwrap()];
    let settings = settings(LeafRule::Ratio, 0.0, 0.1);
    let maps = maps.map(|map| MultilayerTracer::new(Arc::new(map), settings).unwrap());
    let layers = layers.map(|map| MultilayerTracer::new(Arc::new(map), settings).unwrap());
    for &(receiver, light) in rays {
        check_occlusion(&maps[1], receiver, light);
        check_occlusion(&layers[1], receiver, light);
        let found = [
            maps.each_ref().map(|map| map.transmittance(receiver, light, 0.0).unwrap()),
            layers.each_ref().map(|map| map.transmittance(receiver, light, 0.0).unwrap()),
        ];
        for [before, after] in found {
            for channel in 0..T::CHANNELS {
                let (before, after) = (before.channel(channel), after.channel(channel));
                assert!(after <= before + 1e-5, "{receiver} {light}: {before} to {after}");
            }
        }
    }
}

proptest! {
    #![proptest_config(config(91))]

    #[test]
    fn tracing_is_walking_every_pixel(
        sheets in prop_oneof![sheets(1, 9), sheets(4, 6)], pushed_back in any::<bool>(),
        receivers in proptest::collection::vec(receiver(), 6),
        points in [light_point(0.0), light_point(1.0)],
    ) {
        let (light_depth, point) = if pushed_back { (1.0, points[1]) } else { (0.0, points[0]) };
        let rays: Vec<_> = receivers.into_iter().map(|receiver| (receiver, point)).collect();
        check_walks::<f32>(&sheets, light_depth, &rays);
        check_walks::<Rgb>(&sheets, light_depth, &rays);
    }

    #[test]
    fn a_light_without_size_is_a_lookup(
        sheets in prop_oneof![sheets(1, 9), sheets(4, 6)],
        tolerance in proptest::sample::select(vec![0.0, 0.02, 0.1]), receiver in receiver(),
    ) {
        // Not along borders of pixels.
        let receiver = receiver + DVec3::new(0.01, 0.013, 0.0);
        check_point::<f32>(&sheets, tolerance, receiver);
        check_point::<Rgb>(&sheets, tolerance, receiver);
    }

    #[test]
    fn another_occluder_never_lightens(
        sheets in sheets(1, 7), pixel in 0_usize..35,
        (depth, shade) in (2_u8..24, 1_u8..5).prop_map(|(z, a)| (f32::from(z) / 4.0, f32::from(a) / 4.0)),
        receivers in proptest::collection::vec(receiver(), 6), point in light_point(0.0),
    ) {
        let rays: Vec<_> = receivers.into_iter().map(|receiver| (receiver, point)).collect();
        check_occluder::<f32>(&sheets, (pixel, depth, shade), &rays);
        check_occluder::<Rgb>(&sheets, (pixel, depth, shade), &rays);
    }
}

/// One opaque layer over the whole map at depth 2.
fn wall() -> Sheets {
    Sheets { samples: 1, pixels: vec![vec![(2.0, 1.0)]; 35] }
}

#[test]
fn receivers_that_cannot_be_answered_are_lit_and_counted() {
    let map = wall().baker::<f32>(0.0, 0.5).map().unwrap();
    let tracer = MultilayerTracer::new(Arc::new(map.clone()), TraceSettings::default()).unwrap();
    let light = AreaLight::rectangle(DVec3::new(0.0, 0.0, -0.5), DVec3::X * 0.1, DVec3::Y * 0.1);
    let see = |receiver| tracer.visibility(receiver, &light, 3).unwrap();
    assert_eq!(see(DVec3::new(0.0, 0.0, -4.0)), 0.0);
    assert_eq!(tracer.statistics().behind_light, 0);
    let lit = [
        DVec3::new(0.0, 0.0, -0.5),
        DVec3::new(0.0, 0.0, -0.25),
        DVec3::new(0.0, 0.0, 3.0),
        DVec3::NAN,
        DVec3::new(f64::INFINITY, 0.0, 0.0),
    ];
    for (count, receiver) in (1..).zip(lit) {
        assert_eq!(see(receiver), 1.0, "{receiver}");
        assert_eq!(tracer.statistics().behind_light, count * 256);
    }
    assert_eq!(tracer.statistics().rays, 6 * 256);
    assert_eq!(tracer.statistics().outside_map, 0);
    // Beside the view, and a light larger than anything.
    assert_eq!(see(DVec3::new(100.0, 0.0, -4.0)), 1.0);
    assert_eq!(tracer.statistics().outside_map, 256);
    let huge = AreaLight::disk(DVec3::new(0.0, 0.0, -0.5), DVec3::X * 1e9, DVec3::Y * 1e9);
    let seen = tracer.visibility(DVec3::new(0.0, 0.0, -4.0), &huge, 3).unwrap();
    assert!((0.9..=1.0).contains(&seen), "{seen}");
}

#[test]
fn a_map_without_layers_shades_nothing() {
    let empty = Sheets { samples: 1, pixels: vec![Vec::new(); 35] };
    let map = empty.baker::<f32>(0.0, 0.0).map().unwrap();
    let tracer = MultilayerTracer::new(Arc::new(map.clone()), TraceSettings::default()).unwrap();
    let receiver = DVec3::new(0.0, 0.0, -4.0);
    assert_eq!(tracer.transmittance(receiver, DVec3::ZERO, 0.0), Ok(1.0));
}

#[test]
fn settings_and_maps_that_cannot_be_traced_are_refused() {
    let map = wall().baker::<f32>(0.0, 0.0).map().unwrap();
    let good = TraceSettings::default();
    for settings in [
        TraceSettings { rays: 0, ..good },
        TraceSettings { depth_threshold: -1.0, ..good },
        TraceSettings { depth_threshold: f64::NAN, ..good },
        TraceSettings { start: Some(f64::NAN), ..good },
        TraceSettings { start: Some(f64::INFINITY), ..good },
        TraceSettings { stop_below: 2.0, ..good },
    ] {
        let refused = MultilayerTracer::new(Arc::new(map.clone()), settings);
        assert!(matches!(refused, Err(Error::Setting { .. })), "{settings:?}");
    }
    for camera in [None, Some(ShadowCamera::default())] {
        let mut info: LayeredInfo = *map.info();
        info.map.camera = camera;
        let blind = MultilayerMap::new(info, map.pixels().clone());
        assert!(matches!(
            MultilayerTracer::new(Arc::new(blind.clone()), good),
            Err(Error::Camera(_))
        ));
    }
}

#[test]
fn a_threshold_closes_what_lies_beside_the_ray() {
    // The ray crosses the layer's depth one pixel before the layer's.
    let mut sheets = Sheets { samples: 1, pixels: vec![Vec::new(); 35] };
    sheets.pixels[2 * 7 + 2] = vec![(2.0, 1.0)];
    let map = sheets.baker::<f32>(0.0, 0.0).map().unwrap();
    let light = |threshold| {
        let settings = settings(LeafRule::Ratio, threshold, 0.0);
        let tracer = MultilayerTracer::new(Arc::new(map.clone()), settings).unwrap();
        let through = tracer.frame().unproject(3.2, 2.5, 2.0);
        let towards = tracer.frame().unproject(2.5, 2.5, 1.9);
        let receiver = through + (through - towards);
        let light = through + 5.0 * (towards - through);
        tracer.transmittance(receiver, light, 0.0).unwrap()
    };
    assert_eq!([0.0, 0.02, 0.2].map(light), [1.0, 1.0, 0.0]);
}
