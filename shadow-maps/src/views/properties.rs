//! What holds of any depth images and any ray.

use std::ops::ControlFlow;

use dsm_core::{AreaLight, Facing, LightVisibility, Projection, ShadedPoint, View};
use dsm_testkit::config;
use dsm_trace::ShadowRay;
use dsm_trace::detail::{LightFrame, walk_every_pixel};
use glam::DVec3;
use proptest::prelude::*;

use super::depth_view::DepthView;
use super::interval::{self, Interval};
use super::options::TraceOptions;
use super::trace::Walk;
use super::tracer::ViewsTracer;

const SIZE: [u32; 2] = [13, 10];

/// From a point of a light in the plane z = 0, along −z, 90 degrees wide.
fn frame(eye: DVec3) -> LightFrame {
    let view = View { eye, target: eye - DVec3::Z, up: DVec3::Y };
    let view = view.raster(Projection::Perspective { fov: 90.0 }, SIZE).unwrap();
    LightFrame::new(&view.shadow_camera(), SIZE, 0.0).unwrap()
}

/// Eighths, so that rays run along what is there; a slope, a step, and pixels with nothing.
fn image() -> impl Strategy<Value = Vec<f32>> {
    let pixel = prop_oneof![
        1 => Just(0_u8),
        4 => 1_u8..5,
        4 => Just(4_u8),
    ];
    (prop::collection::vec(pixel, (SIZE[0] * SIZE[1]) as usize), 0_u8..3).prop_map(
        |(pixels, slope)| {
            let w = |(at, w): (u32, u8)| match w {
                0 => 0.0,
                w => f32::from(w) / 8.0 + f32::from(slope) * (at % SIZE[0]) as f32 / 64.0,
            };
            (0..).zip(pixels).map(w).collect()
        },
    )
}

fn ray() -> impl Strategy<Value = ShadowRay> {
    let half = |most: u8| (0..most).prop_map(|value| f64::from(value) / 2.0);
    let slope = (-24_i8..25).prop_map(|value| f64::from(value) * 2.0);
    let within = (half(26), half(20), 0_u8..6, 1_u8..9);
    (within, slope.clone(), slope).prop_map(|((x, y, w, length), across, down)| {
        let w = f64::from(w) / 16.0 + 0.03125;
        ShadowRay::new([x, y], w, [across, down], w + f64::from(length) / 16.0)
    })
}

/// A walk through all pixels that a ray crosses, in their order, as naively as can be.
fn naive(view: &DepthView, ray: &ShadowRay) -> (bool, Vec<Interval>) {
    let mut met: Vec<([u32; 2], Interval)> = Vec::new();
    walk_every_pixel(SIZE, ray, &mut |pixel: [u32; 2], enter: f64, leave: f64| {
        met.push((pixel, [enter, leave]));
        ControlFlow::Continue(())
    });
    let mut behind = Vec::new();
    for (index, &(pixel, [enter, leave])) in met.iter().enumerate() {
        let own = f64::from(view.at(pixel));
        if enter <= own && own < leave {
            return (true, behind);
        }
        if own >= leave {
            interval::push(&mut behind, [enter, leave]);
        }
        if let Some(&(next, [entered, _])) = met.get(index + 1)
            && entered == leave
        {
            let other = f64::from(view.at(next));
            let crosses = own.min(other) < leave && leave <= own.max(other);
            if crosses && view.is_wall(pixel, next) {
                return (true, behind);
            }
        }
    }
    (false, behind)
}

fn every_option() -> impl Iterator<Item = TraceOptions> {
    (0..8).map(|bits| TraceOptions {
        hierarchy: bits & 1 > 0,
        clipping: bits & 2 > 0,
        connectedness: bits & 4 > 0,
        ..TraceOptions::NONE
    })
}

/// A point at depth 2.2 to 9 before the light.
fn receiver() -> impl Strategy<Value = DVec3> {
    (2.2_f64..9.0, -0.9_f64..0.9, -0.6_f64..0.6)
        .prop_map(|(depth, x, y)| DVec3::new(x * depth, y * depth, -depth))
}

proptest! {
    #![proptest_config(config(0x0eee_5001))]

    #[test]
    fn accelerations_change_no_answer_of_a_view(
        w in image(), gap in prop_oneof![Just(0.0), 0.0_f64..3.0, Just(f64::INFINITY)],
        ray in ray(),
    ) {
        let view = DepthView::new(frame(DVec3::ZERO), w, gap).unwrap();
        let Some(inside) = ray.crossing([0; 2], SIZE) else { return Ok(()) };
        let ray = ray.between(inside);
        let (blocked, behind) = naive(&view, &ray);
        for options in every_option() {
            let mut passed = Vec::new();
            let found = Walk::new(&view, options, &mut passed).run(&ray).is_break();
            prop_assert_eq!(found, blocked, "{:?}", options);
            if !blocked {
                prop_assert_eq!(&passed, &behind, "{:?}", options);
            }
        }
    }

    #[test]
    fn what_is_left_out_of_later_views_only_unblocks(
        images in prop::collection::vec(image(), 1..4), gap in 0.0_f64..3.0,
        receiver in receiver(), light in prop::array::uniform2(-0.5_f64..0.5),
    ) {
        let eyes = [DVec3::ZERO, DVec3::new(0.5, 0.5, 0.0), DVec3::new(-0.5, 0.25, 0.0)];
        let views: Vec<_> = images
            .into_iter()
            .zip(eyes)
            .map(|(w, eye)| DepthView::new(frame(eye), w, gap).unwrap())
            .collect();
        let tracer = ViewsTracer::new(views).unwrap();
        let light = DVec3::new(light[0], light[1], 0.0);
        let fate = |options| tracer.clone().with_options(options).trace(receiver, light);
        let plain = fate(TraceOptions::NONE);
        for clear_miss in [false, true] {
            for intervals in [false, true] {
                let some = TraceOptions { clear_miss, intervals, ..TraceOptions::NONE };
                let found = fate(some);
                prop_assert!(plain.blocked || !found.blocked, "{:?}", some);
                prop_assert!(found.views <= plain.views || plain.blocked);
                // And the walks do not matter.
                let fast =
                    TraceOptions { hierarchy: true, clipping: true, connectedness: true, ..some };
                prop_assert_eq!(fate(fast).blocked, found.blocked, "{:?}", some);
            }
        }
        let any = tracer.views().iter().any(|view| {
            let one = ViewsTracer::new(vec![view.clone()]).unwrap();
            one.with_options(TraceOptions::NONE).trace(receiver, light).blocked
        });
        prop_assert_eq!(plain.blocked, any);
    }
}

/// A floor at depth 8, and a card at depth 4 whose right edge is at x = 0: what a point
/// of the light at `eye` sees of them.
fn stage(eye: DVec3) -> DepthView {
    let frame = frame(eye);
    let w = |at: u32| {
        let [x, y] = [at % SIZE[0], at / SIZE[0]].map(|at| f64::from(at) + 0.5);
        if frame.unproject(x, y, 4.0).x < 0.0 { 0.25 } else { 0.125 }
    };
    DepthView::new(frame, (0..SIZE[0] * SIZE[1]).map(w).collect(), DepthView::GAP).unwrap()
}

#[test]
fn rays_are_blocked_by_what_any_view_sees() {
    let eyes = [DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 0.0, 0.0)];
    let tracer = ViewsTracer::new(eyes.map(stage).to_vec()).unwrap();
    // Well behind the card, and well beside it.
    let fate = |x: f64| tracer.trace(DVec3::new(x, 0.3, -7.5), DVec3::new(0.1, 0.05, 0.0));
    assert!(fate(-3.0).blocked);
    let clear = fate(3.0);
    assert!(!clear.blocked && clear.views == 1, "a clear miss: {clear:?}");
    // Nearer than the card everything is lit.
    let near = tracer.trace(DVec3::new(-1.0, 0.3, -3.0), DVec3::ZERO);
    assert!(!near.blocked);
    // Beside the light, or nowhere.
    for receiver in [DVec3::Z, DVec3::splat(f64::NAN), DVec3::ZERO] {
        assert!(!tracer.trace(receiver, DVec3::ZERO).blocked);
    }
}

#[test]
fn surfaces_are_dark_on_the_side_that_is_turned_from_the_light() {
    let tracer = ViewsTracer::new(vec![stage(DVec3::ZERO)]).unwrap().with_rays(64);
    let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.25, DVec3::Y * 0.25);
    let ask = |facing| {
        let position = DVec3::new(3.0, 0.3, -7.9);
        let mut values = Vec::new();
        let point = ShadedPoint { position, facing, seed: 1 };
        let Ok(()) = tracer.visibilities(&[point], &light, &mut values);
        values[0]
    };
    assert_eq!(ask(Facing::Light), 1.0);
    assert_eq!(ask(Facing::Surface(DVec3::Z)), 1.0);
    assert_eq!(ask(Facing::Surface(DVec3::NEG_Z)), 0.0);
    // Edge on: half of the light is above.
    let across = DVec3::new(3.0, 0.3, -7.9).cross(DVec3::Y).normalize();
    assert!((ask(Facing::Surface(across)) - 0.5).abs() < 0.05);
}

#[test]
fn what_is_no_view_is_refused() {
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let make = |w: Vec<f32>, gap| DepthView::new(frame(DVec3::ZERO), w, gap);
    assert!(make(vec![0.0; pixels], 1.0).is_ok());
    assert!(make(vec![0.0; pixels - 1], 1.0).is_err());
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        let mut w = vec![0.0; pixels];
        w[7] = bad;
        assert!(make(w, 1.0).is_err(), "{bad}");
    }
    assert!(make(vec![0.0; pixels], -1.0).is_err() && make(vec![0.0; pixels], f64::NAN).is_err());
    assert!(ViewsTracer::new(Vec::new()).is_err());
}
