//! Percentage closer soft shadows of maps of layers.

use dsm_core::{AreaLight, LightVisibility, Rgb, VisibilityField};
use glam::DVec3;
use mtsm::detail::{FilteredLayers, SoftPercentageCloser, TracedMap};
use std::sync::Arc;

use crate::views::Sheets;

/// Opaque in the left part of the map, up to column 3, at depth 2; glass behind
/// it everywhere.
fn half() -> Sheets {
    let pixel = |pixel: usize| {
        let wall = (pixel % 7 < 3).then_some((2.0, 1.0));
        wall.into_iter().chain([(3.0, 0.5)]).collect()
    };
    Sheets { samples: 1, pixels: (0..35).map(pixel).collect() }
}

fn see<M: TracedMap + Clone>(
    map: &M,
    layers: FilteredLayers,
    receiver: DVec3,
    light: &AreaLight,
) -> M::Value {
    let filter =
        SoftPercentageCloser::new(Arc::new(map.clone()), layers).unwrap().with_taps(4096).unwrap();
    filter.visibility(receiver, light, 5).unwrap()
}

#[test]
fn the_region_is_that_of_equation_1() {
    let map = half().baker::<f32>(0.0, 0.0).depth_map().unwrap();
    let receiver = DVec3::new(0.0, 0.0, -8.0);
    for radius in [0.1, 0.2, 0.4] {
        let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * radius, DVec3::Y * radius);
        // 7 pixels are 2 units wide at depth 1: the wall's edge is half a pixel
        // from the middle.
        let half_size = 3.5 * radius * (1.0 / 2.0 - 1.0 / 8.0);
        let blocked = (half_size - 0.5_f64).max(0.0) / (2.0 * half_size);
        for (layers, glass) in [(FilteredLayers::Shallowest, 0.5), (FilteredLayers::All, 0.5)] {
            let expected = (1.0 - blocked) * glass;
            let seen = f64::from(see(&map, layers, receiver, &light));
            assert!((seen - expected).abs() < 0.01, "{radius} {layers:?}: {seen}, not {expected}");
        }
    }
}

#[test]
fn without_size_it_is_a_lookup() {
    let baker = half().baker::<Rgb>(0.0, 0.0);
    let (map, depths) = (baker.map().unwrap(), baker.depth_map().unwrap());
    let light = AreaLight::point(DVec3::ZERO);
    for depth in [1.5, 2.0, 2.5, 3.0, 5.0] {
        for x in [-0.7, 0.3] {
            let receiver = DVec3::new(x * depth, 0.1 * depth, -depth);
            let pixel = [if x < 0.0 { 1 } else { 4 }, 2];
            let expected = map.evaluate(pixel, depth as f32).unwrap();
            assert_eq!(see(&map, FilteredLayers::All, receiver, &light), expected, "{receiver}");
            assert_eq!(see(&depths, FilteredLayers::All, receiver, &light), expected);
            // The wall alone, or where there is none the glass.
            let first = if x < 0.0 && depth >= 2.0 { Rgb::new(0.0, 0.0, 0.0) } else { expected };
            assert_eq!(see(&depths, FilteredLayers::Shallowest, receiver, &light), first);
            assert_eq!(see(&map, FilteredLayers::Shallowest, receiver, &light), first);
        }
    }
}

#[test]
fn bias_and_odd_receivers() {
    let map = half().baker::<f32>(0.0, 0.0).depth_map().unwrap();
    let light = AreaLight::sphere(DVec3::ZERO, 0.1);
    let filter = SoftPercentageCloser::new(Arc::new(map.clone()), FilteredLayers::All).unwrap();
    let on_the_wall = DVec3::new(-1.6, 0.0, -2.1);
    assert_eq!(filter.visibility(on_the_wall, &light, 0), Ok(0.0));
    for receiver in [DVec3::NAN, DVec3::ZERO, DVec3::Z, DVec3::new(0.0, 0.0, -1.0)] {
        assert_eq!(filter.visibility(receiver, &light, 0), Ok(1.0), "{receiver}");
    }
    assert_eq!(filter.visibility(DVec3::new(90.0, 0.0, -9.0), &light, 0), Ok(1.0));
    let counted = filter.statistics();
    assert_eq!([counted.rays, counted.outside_map, counted.behind_light], [6 * 256, 256, 3 * 256]);
    let biased = filter.with_bias(0.2).unwrap();
    assert_eq!(biased.visibility(on_the_wall, &light, 0), Ok(1.0));
    // A pixel there is 2 · 2.1 / 7 wide or 2 · 2.1 / 5 high: more than 0.1.
    let biased = biased.with_bias(0.0).unwrap();
    assert_eq!(biased.visibility(on_the_wall, &light, 0), Ok(0.0));
    let biased = biased.with_pixel_bias();
    assert_eq!(biased.visibility(on_the_wall, &light, 0), Ok(1.0));
    assert!(biased.with_bias(f64::NAN).is_err());
    let filter = SoftPercentageCloser::new(Arc::new(map.clone()), FilteredLayers::All).unwrap();
    assert!(filter.with_taps(0).is_err());
}
