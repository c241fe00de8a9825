//! What holds of any scene and any light.

use std::ops::ControlFlow;

use dsm_core::{
    AreaLight, Error, Facing, HitSource, LightVisibility, Projection, RayHits, RaySource,
    SamplePoint, ShadedPoint, SurfaceHit, TileHits, TileSamples, View, ViewRaster,
};
use dsm_testkit::config;
use glam::{DVec2, DVec3, Vec3};
use proptest::prelude::*;

use super::builder::AttenuationBuilder;
use super::map::AttenuationMap;
use super::oracle::{self, Pixel};
use super::shadow::AttenuationShadow;
use super::warp::Warp;
use crate::prefilter::lists::FragmentLists;

const SIZE: [u32; 2] = [15, 11];

/// From the origin along −z, 90 degrees wide.
fn centre(size: [u32; 2]) -> ViewRaster {
    let view = View { eye: DVec3::ZERO, target: DVec3::NEG_Z, up: DVec3::Y };
    view.raster(Projection::Perspective { fov: 90.0 }, size).unwrap()
}

/// What pixels show, as they were made up.
struct Pixels<'a>(&'a [Pixel]);

impl HitSource<f32> for Pixels<'_> {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<f32>) -> Result<(), Error> {
        for sample in 0..samples.len() {
            let point = samples.point(sample);
            let at = point.y as usize * SIZE[0] as usize + point.x as usize;
            for &(depth, opacity) in &self.0[at] {
                hits.push_surface(sample, SurfaceHit { depth, opacity })?;
            }
        }
        Ok(())
    }
}

fn pixels() -> impl Strategy<Value = Vec<Pixel>> {
    let opacity = prop_oneof![Just(1.0_f32), 0.05_f32..1.0];
    let pixel = prop::collection::vec((2.0_f32..9.0, opacity), 0..4).prop_map(|mut hits| {
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        hits
    });
    prop::collection::vec(pixel, (SIZE[0] * SIZE[1]) as usize)
}

/// An opaque floor that tilts along x, and a square card in front of it.
#[derive(Clone, Copy, Debug)]
struct Stage {
    floor: f64,
    tilt: f64,
    card: Option<(f64, f64)>,
}

impl Stage {
    /// The depth and the normal of what a ray from `eye` along (`across`, −1) meets.
    fn met(&self, eye: DVec3, across: DVec2) -> (f32, Vec3) {
        if let Some((depth, half)) = self.card {
            let along = depth + eye.z;
            let at = eye.truncate() + across * along;
            if along > 0.0 && at.abs().max_element() <= half {
                return (along as f32, Vec3::Z);
            }
        }
        // z = −floor + tilt · x.
        let depth = (self.floor + eye.z - self.tilt * eye.x) / (1.0 + self.tilt * across.x);
        (depth as f32, Vec3::new(-self.tilt as f32, 0.0, 1.0))
    }

    /// The map of these points of a light.
    fn shadow(
        &self,
        size: [u32; 2],
        points: impl Iterator<Item = DVec3>,
    ) -> (AttenuationShadow<AttenuationMap<f32>>, Vec<u64>) {
        let centre = centre(size);
        let mut builder = AttenuationBuilder::<f32>::new(centre.shadow_camera(), size).unwrap();
        for eye in points {
            let view = centre.at_eye(eye);
            let source = Staged { stage: *self, view };
            let watch = || ControlFlow::Continue(());
            let _ = builder.add_view(&source, view.shadow_camera(), watch).unwrap();
        }
        let (lists, counts) = builder.finish().unwrap();
        lists.check().unwrap();
        let map = AttenuationMap::new(*builder.frame(), lists).unwrap();
        (AttenuationShadow::new(map), counts.layers)
    }
}

struct Staged {
    stage: Stage,
    view: ViewRaster,
}

impl HitSource<f32> for Staged {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<f32>) -> Result<(), Error> {
        for sample in 0..samples.len() {
            let point = samples.point(sample);
            let ray = self.view.ray(point.x, point.y, 0.0);
            let across = (ray.at(1.0) - ray.at(0.0)).truncate();
            let (depth, normal) = self.stage.met(self.view.eye(), across);
            if depth > 0.0 && depth < 1e6 {
                let hit = SurfaceHit { depth, opacity: 1.0 };
                hits.push_surface_with_normal(sample, hit, normal)?;
            }
        }
        Ok(())
    }
}

fn light(half: f64) -> AreaLight {
    AreaLight::rectangle(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)
}

/// A point of a surface, which faces along `normal`.
fn on(position: DVec3, normal: DVec3) -> ShadedPoint {
    ShadedPoint { position, facing: Facing::Surface(normal.normalize()), seed: 0 }
}

fn ask(shadow: &AttenuationShadow<AttenuationMap<f32>>, point: ShadedPoint) -> f32 {
    let mut values = Vec::new();
    let Ok(()) = shadow.visibilities(&[point], &light(1.0), &mut values);
    values[0]
}

proptest! {
    #![proptest_config(config(0xa99a_a001))]

    #[test]
    fn layers_are_naive_ones(
        pixels in prop::collection::vec(pixels(), 1..4),
        eyes in prop::collection::vec(prop::array::uniform2(-0.6_f64..0.6), 4),
        depth in prop_oneof![Just(0.0), 0.01_f64..0.5],
        tolerance in 0.0_f64..2.0,
    ) {
        let centre = centre(SIZE);
        let camera = centre.shadow_camera();
        let mut builder =
            AttenuationBuilder::<f32>::with_tolerance(camera, SIZE, tolerance).unwrap();
        let mut views = Vec::new();
        for (pixels, eye) in pixels.into_iter().zip(eyes) {
            let view = centre.at_eye(DVec3::new(eye[0], eye[1], depth * eye[0]));
            let watch = || ControlFlow::Continue(());
            let _ = builder.add_view(&Pixels(&pixels), view.shadow_camera(), watch).unwrap();
            views.push((view, pixels));
        }
        let (lists, _) = builder.finish().unwrap();
        lists.check().unwrap();
        let reach = tolerance * builder.frame().footprint(1.0);
        let mut close = 0;
        for (y, x) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (y, x))) {
            let mut expected = oracle::layers(&centre, &views, [x, y], reach);
            expected.sort_by(|a, b| b.0.total_cmp(&a.0));
            let list = lists.at(x.into(), y.into());
            // Where rounding decides what is one layer.
            if list.w.len() != expected.len() {
                close += 1;
                continue;
            }
            for ((&w, &share), (want, count, seen)) in
                list.w.iter().zip(list.opacities).zip(expected)
            {
                prop_assert!(count <= f64::from(seen) && seen as usize <= views.len());
                prop_assert!((f64::from(w) - want).abs() < 1e-6 * want);
                let held = oracle::holding(&centre, &views, [x, y], want);
                let all = f64::from(held.max(seen));
                prop_assert!((f64::from(share) - count / all).abs() < 1e-5, "{} {} {}", share, count, all);
            }
        }
        prop_assert!(close <= 1, "{}", close);
    }

    #[test]
    fn a_plane_with_nothing_between_is_lit(
        half in 0.0_f64..1.5, floor in 2.0_f64..50.0, count in 1_u32..20, seed in any::<u64>(),
        place in prop::array::uniform2(-0.98_f64..0.98),
    ) {
        let stage = Stage { floor, tilt: 0.0, card: None };
        let points = light(half).samples(DVec3::NEG_Z, count, seed);
        let (shadow, layers) = stage.shadow([20, 20], points);
        let at = DVec2::from(place).extend(-1.0) * floor;
        for shadow in [shadow.clone(), shadow.with_bilinear(true)] {
            prop_assert_eq!(ask(&shadow, on(at, DVec3::Z)), 1.0);
        }
        // One layer a texel, of the first view or of one that sees what it does not.
        prop_assert!(layers.iter().all(|&layers| layers <= 400), "{:?}", layers);
    }

    #[test]
    fn a_slope_that_faces_the_light_is_lit(
        half in 0.01_f64..0.5, tilt in -1.0_f64..1.0, seed in any::<u64>(),
        place in prop::array::uniform2(-0.9_f64..0.9),
    ) {
        let stage = Stage { floor: 8.0, tilt, card: None };
        let points = light(half).samples(DVec3::NEG_Z, 6, seed);
        let (shadow, _) = stage.shadow([32, 32], points);
        let across = DVec2::from(place) * 0.45;
        let (depth, normal) = stage.met(DVec3::ZERO, across);
        let at = across.extend(-1.0) * f64::from(depth);
        for shadow in [shadow.clone(), shadow.with_bilinear(true)] {
            let found = ask(&shadow, on(at, normal.as_dvec3()));
            prop_assert!(found > 0.999, "{}", found);
        }
    }

    #[test]
    fn behind_a_card_it_is_dark_and_beside_it_is_lit(
        half in 0.05_f64..0.6, card in 2.0_f64..4.0, floor in 5.0_f64..9.0, wide in 0.9_f64..1.5,
        count in 1_u32..12, seed in any::<u64>(), place in prop::array::uniform2(-1.0_f64..1.0),
    ) {
        let stage = Stage { floor, tilt: 0.0, card: Some((card, wide)) };
        let points = light(half).samples(DVec3::NEG_Z, count, seed);
        let (shadow, _) = stage.shadow([48, 48], points);
        // Of a full umbra, and of no shadow, from similar triangles; two texels off.
        let side = 2.0 * 2.0 * floor / 48.0;
        let umbra = wide * floor / card - half * (floor - card) / card - side;
        let lit = wide * floor / card + half * (floor - card) / card + side;
        let inside = DVec2::from(place) * umbra;
        prop_assume!(umbra > 0.0);
        for shadow in [shadow.clone(), shadow.with_bilinear(true)] {
            prop_assert_eq!(ask(&shadow, on(inside.extend(-floor), DVec3::Z)), 0.0);
            let beside = DVec3::new(lit, place[1] * lit, -floor);
            if lit < 0.97 * floor {
                prop_assert_eq!(ask(&shadow, on(beside, DVec3::Z)), 1.0);
            }
            // Its last texels may be seen beside their middles.
            let on_card = (DVec2::from(place) * (wide - 2.0 * card / 48.0 * 1.5)).extend(-card);
            prop_assert_eq!(ask(&shadow, on(on_card, DVec3::Z)), 1.0);
        }
    }
}

#[test]
fn a_leaf_is_dark_on_the_side_that_is_turned_from_the_light() {
    let stage = Stage { floor: 6.0, tilt: 0.0, card: Some((3.0, 0.8)) };
    let points = light(0.25).samples(DVec3::NEG_Z, 16, 1);
    let (shadow, _) = stage.shadow([64, 64], points);
    // In the middle of a texel, where no plane is followed.
    let at = DVec3::new(1.0 / 64.0, -1.0 / 64.0, -1.0) * 3.0;
    for shadow in [shadow.clone(), shadow.with_bilinear(true)] {
        assert_eq!(ask(&shadow, on(at, DVec3::Z)), 1.0);
        assert_eq!(ask(&shadow, on(at, DVec3::NEG_Z)), 0.0);
        // Edge on, some of it: no more than lies above.
        let edge = ask(&shadow, on(at, at.cross(DVec3::Y)));
        assert!((0.4..0.6).contains(&edge), "{edge}");
    }
}

#[test]
fn penumbrae_are_the_lights_share() {
    for (half, seed) in [(0.2, 3), (0.35, 1), (0.6, 2)] {
        // The edge of a card: the light's share is nearly linear.
        let (card, floor) = (3.0, 8.0);
        let stage = Stage { floor, tilt: 0.0, card: Some((card, 0.5)) };
        let points = light(half).samples(DVec3::NEG_Z, 100, seed);
        let (shadow, _) = stage.shadow([96, 96], points);
        let shadow = shadow.with_bilinear(true);
        let (middle, reach) = (0.5 * floor / card, half * (floor - card) / card);
        for step in -9..=9 {
            let at = DVec3::new(middle + f64::from(step) / 10.0 * reach, 0.0, -floor);
            // Seen past a card as high as wide.
            let along = |light: f64, at: f64| at + (light - at) * (floor - card) / floor;
            let hidden = (0..200)
                .flat_map(|u| (0..200).map(move |v| (u, v)))
                .filter(|&(u, v)| {
                    let [u, v] = [u, v].map(|step| half * (f64::from(step) + 0.5) / 100.0 - half);
                    along(u, at.x).abs() <= 0.5 && along(v, at.y).abs() <= 0.5
                })
                .count();
            let truth = 1.0 - hidden as f64 / 40_000.0;
            let found = f64::from(ask(&shadow, on(at, DVec3::Z)));
            // What splats add to edges is half a texel of the floor, over the penumbra; the
            // rest is that points are 100.
            let texel = 2.0 * floor / 96.0 / (2.0 * reach);
            assert!((found - truth).abs() < texel + 0.05, "{half} {step}: {found} {truth} {texel}");
        }
    }
}

#[test]
fn layers_hardly_rise_after_the_first_views() {
    let stage = Stage { floor: 8.0, tilt: 0.2, card: Some((4.0, 1.0)) };
    let points = light(0.4).samples(DVec3::NEG_Z, 64, 1);
    let (_, layers) = stage.shadow([64, 64], points);
    let [first, few, all] = [0, 15, 63].map(|view| layers[view] as f64 / 4096.0);
    assert!(first <= 1.01 && few > 1.02 && all < 1.1 * few, "{first} {few} {all}");
}

#[test]
fn glass_counts_for_what_it_passes() {
    let centre = centre([8, 8]);
    let mut builder = AttenuationBuilder::<f32>::new(centre.shadow_camera(), [8, 8]).unwrap();
    for opacity in [0.25_f32, 0.75] {
        let source = RaySource(|_: SamplePoint, hits: &mut RayHits<f32>| -> Result<(), Error> {
            hits.push_surface(SurfaceHit { depth: 4.0, opacity: 1.0 })?;
            hits.push_surface(SurfaceHit { depth: 2.0, opacity })
        });
        let watch = || ControlFlow::Continue(());
        let _ = builder.add_view(&source, centre.shadow_camera(), watch).unwrap();
    }
    let (lists, counts) = builder.finish().unwrap();
    let list = lists.list(9);
    assert_eq!((list.w, list.opacities), (&[0.5, 0.25][..], &[1.0, 0.5][..]));
    assert_eq!(counts.hits, 4 * 64);
    assert_eq!(counts.layers, [128, 128]);
}

/// Four texels around (4, 4), each of which holds this.
fn corners(texels: [Option<(f32, f32)>; 4]) -> AttenuationShadow<AttenuationMap<f32>> {
    let mut lists = FragmentLists::new([8, 8]);
    for texel in 0..64_u32 {
        let [x, y] = [texel % 8, texel / 8];
        if (3..5).contains(&x)
            && (3..5).contains(&y)
            && let Some((depth, share)) = texels[(2 * (y - 3) + (x - 3)) as usize]
        {
            lists.push(depth.recip(), share);
        }
        lists.finish_texel().unwrap();
    }
    let frame =
        *AttenuationBuilder::<f32>::new(centre([8, 8]).shadow_camera(), [8, 8]).unwrap().frame();
    AttenuationShadow::new(AttenuationMap::new(frame, lists).unwrap()).with_bias(0.1).unwrap()
}

#[test]
fn the_nearest_layer_answers_within_the_bias() {
    let here = |depth: f64| ShadedPoint {
        position: DVec3::new(0.1, -0.1, -1.0) * depth,
        facing: Facing::Light,
        seed: 0,
    };
    let shadow = corners([None, None, None, Some((4.0, 0.75))]);
    for (depth, share) in [(4.0, 0.75), (4.09, 0.75), (3.91, 0.75), (4.11, 0.0), (3.89, 0.0)] {
        assert_eq!(ask(&shadow, here(depth)), share, "{depth}");
    }
    // Behind the light, beside the map, and nowhere.
    let lit = [DVec3::Z, DVec3::new(9.0, 0.0, -4.0), DVec3::splat(f64::NAN)];
    for position in lit {
        assert_eq!(ask(&shadow, ShadedPoint { position, facing: Facing::Light, seed: 0 }), 1.0);
    }
    assert!(shadow.clone().with_bias(-1.0).is_err() && shadow.with_bias(f64::NAN).is_err());
}

#[test]
fn four_texels_are_interpolated() {
    let at = |x: f64, y: f64| ShadedPoint {
        position: DVec3::new(x, y, -4.0),
        facing: Facing::Light,
        seed: 0,
    };
    let layer = |share| Some((4.0, share));
    let all = corners([layer(0.25), layer(0.5), layer(0.75), layer(1.0)]).with_bilinear(true);
    assert_eq!(ask(&all, at(0.0, 0.0)), 0.625);
    assert_eq!(ask(&all, at(-0.5, 0.5)), 0.25);
    assert_eq!(ask(&all, at(0.25, 0.5)), 0.25 + 0.25 * 0.75);
    // What lies before the point darkens; what is past its edge does not count.
    let edge = |other| corners([layer(0.5), other, layer(0.5), other]).with_bilinear(true);
    assert_eq!(ask(&edge(Some((2.0, 1.0))), at(0.0, 0.0)), 0.25);
    for beside in [Some((6.0, 1.0)), None] {
        assert_eq!(ask(&edge(beside), at(0.0, 0.0)), 0.5);
    }
    assert_eq!(ask(&corners([None; 4]).with_bilinear(true), at(0.0, 0.0)), 0.0);
}

#[test]
fn what_is_no_map_is_refused() {
    let camera = centre(SIZE).shadow_camera();
    let builder = |tolerance| AttenuationBuilder::<f32>::with_tolerance(camera, SIZE, tolerance);
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(builder(bad).is_err(), "{bad}");
    }
    assert!(builder(1.0).unwrap().finish().is_err(), "no views");
    assert!(AttenuationBuilder::<f32>::new(camera, [1 << 20, 1 << 20]).is_err());
    // A view that looks away sees nothing of the map: an empty one is dark.
    let mut builder = builder(1.0).unwrap();
    let away = View { eye: DVec3::ZERO, target: DVec3::Z, up: DVec3::Y };
    let away = away.raster(Projection::Perspective { fov: 90.0 }, SIZE).unwrap();
    let source = Staged { stage: Stage { floor: 4.0, tilt: 0.0, card: None }, view: centre(SIZE) };
    let watch = || ControlFlow::Continue(());
    let _ = builder.add_view(&source, away.shadow_camera(), watch).unwrap();
    let (lists, counts) = builder.finish().unwrap();
    assert!(lists.is_empty() && counts.hits > 0);
}

#[test]
fn planar_lights_are_warped_by_translation() {
    let centre = centre(SIZE);
    let camera = centre.shadow_camera();
    let frame = *AttenuationBuilder::<f32>::new(camera, SIZE).unwrap().frame();
    let beside = centre.at_eye(DVec3::new(0.3, -0.2, 0.0)).shadow_camera();
    let own = dsm_trace::detail::LightFrame::new(&beside, SIZE, 0.0).unwrap();
    let warp = Warp::new((&beside, &own), (&camera, &frame)).unwrap();
    // Equation 3: in proportion to 1 / z, by the focal length in pixels.
    let moved = warp.there([7.5, 5.5, 0.5]).unwrap();
    assert!((moved[0] - 7.5 - 0.3 * 7.5 * 0.5).abs() < 1e-9, "{moved:?}");
    assert!((moved[1] - 5.5 - 0.2 * 7.5 * 0.5).abs() < 1e-9, "{moved:?}");
}
