//! Tests: receivers on surfaces that the map shows.

use dsm_core::{AreaLight, Facing, LightVisibility, ShadedPoint};
use dsm_trace::detail::LightFrame;
use glam::DVec3;

use super::fragment::Fragment;
use super::map::FragmentMap;
use super::oracle::{frame, map};
use super::tracer::FragmentTracer;

/// A surface through a point with a normal, in the pixels and cells where `covers` says.
struct Patch {
    point: DVec3,
    normal: DVec3,
    opacity: f32,
    covers: fn(DVec3) -> bool,
}

/// A map of patches as their cells' middles see them.
fn shown(frame: LightFrame, patches: &[Patch]) -> FragmentMap<f32> {
    let [width, height] = frame.size();
    let mut pixels = vec![Vec::new(); (width * height) as usize];
    for (pixel, list) in pixels.iter_mut().enumerate() {
        let corner = [pixel as u32 % width, pixel as u32 / width].map(f64::from);
        for patch in patches {
            let at = |x: f64, y: f64| {
                let along = frame.unproject(corner[0] + x, corner[1] + y, 1.0);
                along * (patch.point.dot(patch.normal) / along.dot(patch.normal))
            };
            let cell = |bit: u32| {
                let middle = |at: u32| (f64::from(at) + 0.5) / 8.0;
                let met = at(middle(bit % 8), middle(bit / 8));
                met.z < 0.0 && (patch.covers)(met)
            };
            let coverage = (0..64).filter(|&bit| cell(bit)).fold(0, |all, bit| all | 1_u64 << bit);
            let depth = -at(0.5, 0.5).z;
            let slope = frame.plane(corner[0] + 0.5, corner[1] + 0.5, depth, patch.normal);
            if let Some(slope) = slope.filter(|_| coverage != 0) {
                list.push(Fragment {
                    w: depth.recip() as f32,
                    gradient: Some(slope.map(|along| along as f32)),
                    opacity: patch.opacity,
                    coverage,
                });
            }
        }
    }
    map(frame, &pixels)
}

fn light() -> AreaLight {
    AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.3, DVec3::Y * 0.3)
}

/// The light at receivers off a surface by so much to a side, told or not.
fn at(tracer: &FragmentTracer<f32>, on: DVec3, normal: DVec3, off: f64, told: bool) -> f32 {
    let facing = if told { Facing::Surface(normal) } else { Facing::Light };
    let point = ShadedPoint { position: on + normal * off, facing, seed: 7 };
    let mut values = Vec::new();
    tracer.visibilities(&[point], &light(), &mut values).unwrap();
    values[0]
}

/// A sheet at −z = 4, tilted, seen by 64 × 64 pixels that are an eighth wide there.
fn sheet(opacity: f32) -> (FragmentTracer<f32>, DVec3) {
    let normal = DVec3::new(0.3, -0.2, 1.0).normalize();
    let point = DVec3::new(0.0, 0.0, -4.0);
    let patch = Patch { point, normal, opacity, covers: |at| at.x.abs() < 2.0 };
    (FragmentTracer::new(shown(frame([64, 64], 0.0), &[patch])).unwrap(), normal)
}

fn on_sheet(normal: DVec3) -> impl Iterator<Item = DVec3> {
    (0..40).map(move |at| {
        let (x, y) = (f64::from(at % 8) * 0.37 - 1.4, f64::from(at / 8) * 0.41 - 0.9);
        DVec3::new(x, y, -4.0 - (normal.x * x + normal.y * y) / normal.z)
    })
}

#[test]
fn a_surface_shades_its_far_side_alone_and_once() {
    for opacity in [1.0, 0.75] {
        let (tracer, normal) = sheet(opacity);
        for on in on_sheet(normal) {
            // However little off, where the side is told; and untold where numbers tell.
            for (off, told) in
                [(0.0, true), (1e-12, true), (1e-5, true), (0.01, true), (0.01, false)]
            {
                let lit = at(&tracer, on, normal, off, told);
                let dark = at(&tracer, on, -normal, off, told);
                assert!((lit - 1.0).abs() < 1e-6, "{on} {off} {told}: {lit}");
                assert!((dark - 1.0 + opacity).abs() < 1e-6, "{on} {off} {told}: {dark}");
            }
            // On it by its numbers alone: taken to be on the side of the light.
            assert_eq!(at(&tracer, on.as_vec3().as_dvec3(), normal, 0.0, false), 1.0);
        }
    }
}

#[test]
fn what_is_near_a_receiver_shades_it() {
    // A wall that stands on a floor: 0.002 before it, a sixtieth of a pixel, it is seen.
    let floor = DVec3::Z;
    let wall = Patch {
        point: DVec3::new(0.5, 0.0, -4.0),
        normal: DVec3::X,
        opacity: 1.0,
        covers: |at| at.z > -4.0 && at.z < -2.5,
    };
    let ground =
        Patch { point: DVec3::new(0.0, 0.0, -4.0), normal: floor, opacity: 1.0, covers: |_| true };
    let tracer = FragmentTracer::new(shown(frame([64, 64], 0.0), &[wall, ground])).unwrap();
    let told = |x: f64, y: f64| at(&tracer, DVec3::new(x, y, -4.0), floor, 1e-9, true);
    for y in [-0.7, -0.31, 0.03, 0.44, 0.81] {
        // Behind it no light gets around its foot, from before all.
        assert_eq!(told(0.52, y), 0.0, "{y}");
        assert_eq!(told(0.46, y), 1.0, "{y}");
    }
}

#[test]
fn neighbours_of_one_surface_do_not_shade_it() {
    // A ridge between two planes that turn away from the light: cells that it passes
    // show one of them where the other is.
    let normals = [DVec3::new(-0.6, 0.1, 1.0).normalize(), DVec3::new(0.5, 0.1, 1.0).normalize()];
    let point = DVec3::new(0.03, 0.0, -4.0);
    let patch = |side: usize, covers| Patch { point, normal: normals[side], opacity: 1.0, covers };
    let sides = [patch(0, |at: DVec3| at.x < 0.03), patch(1, |at: DVec3| at.x >= 0.03)];
    let tracer = FragmentTracer::new(shown(frame([64, 64], 0.0), &sides)).unwrap();
    for step in -20..20 {
        let side = usize::from(step >= 0);
        let x = (f64::from(step) + 0.5) * 1e-3;
        for y in [-0.6, 0.11, 0.5] {
            let normal = normals[side];
            let on = DVec3::new(0.03 + x, y, -4.0 - (normal.x * x + normal.y * y) / normal.z);
            let lit = at(&tracer, on, normal, 1e-9, true);
            assert_eq!(lit, 1.0, "{x} {y}");
            assert_eq!(at(&tracer, on, -normal, 1e-9, true), 0.0, "{x} {y}");
        }
    }
}

/// The light at a receiver among half planes through a line along y, each on the side of
/// `x` below 0.03 or not: by rays to a grid of the light's points.
fn truth(receiver: DVec3, sheets: &[(DVec3, bool)]) -> f64 {
    let edge = DVec3::new(0.03, 0.0, -4.0);
    let is_met = |light: DVec3, &(normal, below): &(DVec3, bool)| {
        let way = light - receiver;
        let share = (edge - receiver).dot(normal) / way.dot(normal);
        let x = receiver.x + share * way.x;
        share > 0.0 && share < 1.0 && (x < 0.03) == below
    };
    let side = |step: u32| 0.3 * (2.0 * (f64::from(step) + 0.5) / 64.0 - 1.0);
    let lights = (0..64 * 64).map(|at| DVec3::new(side(at % 64), side(at / 64), 0.0));
    let lit = lights.filter(|&light| !sheets.iter().any(|sheet| is_met(light, sheet))).count();
    lit as f64 / 4096.0
}

#[test]
fn planes_that_meet_in_an_edge_end_there() {
    let below = |at: DVec3| at.x < 0.03;
    let beyond = |at: DVec3| at.x >= 0.03;
    let point = DVec3::new(0.03, 0.0, -4.0);
    // A ridge, a valley, and an edge against the sky: outward normals, which side of the
    // edge each is on, and along which it goes down from it.
    // With how many receivers may be off: those that see a part of the light by less of the
    // edge than a cell shows.
    let bodies = [
        [(DVec3::new(-0.5, 0.0, 1.0), true), (DVec3::new(0.4, 0.0, 1.0), false)],
        [(DVec3::new(0.5, 0.0, 1.0), true), (DVec3::new(-0.4, 0.0, 1.0), false)],
        [(DVec3::new(4.0, 0.0, 1.0), true), (DVec3::new(5.0, 0.0, -1.0), true)],
    ];
    for (body, most) in bodies.into_iter().zip([0, 0, 8]) {
        let sheets = body.map(|(normal, side)| (normal.normalize(), side));
        let patches = sheets.map(|(normal, side)| Patch {
            point,
            normal,
            opacity: 1.0,
            covers: if side { below } else { beyond },
        });
        let tracer = FragmentTracer::new(shown(frame([64, 64], 0.0), &patches)).unwrap();
        let mut off = Vec::new();
        for (normal, side) in sheets {
            let mut along = DVec3::Y.cross(normal);
            along *= if (along.x < 0.0) == side { 1.0 } else { -1.0 };
            for step in 0..40 {
                // A fortieth of a pixel off, up to four cells from the edge, on either side.
                let on = point + along * (f64::from(step) + 0.5) * 1.6e-3;
                for lift in [0.003, -0.003] {
                    let receiver = on + normal * lift + DVec3::Y * 0.013 * f64::from(step);
                    let have = at(&tracer, receiver, DVec3::ZERO, 0.0, false);
                    off.push(f64::from(have) - truth(receiver, &sheets));
                }
            }
        }
        let wrong = off.iter().filter(|off| off.abs() > 0.1).count();
        assert!(wrong <= most, "{body:?}: {wrong} of {}: {off:.2?}", off.len());
    }
}

#[test]
fn no_ray_passes_between_two_pixels() {
    // Receivers on the borders and corners of pixels, and lights so small that their rays
    // leave a border by less than numbers there tell apart.
    let wall = Patch {
        point: DVec3::new(0.0, 0.0, -3.0),
        normal: DVec3::new(0.2, -0.1, 1.0).normalize(),
        opacity: 1.0,
        covers: |_| true,
    };
    let frame = frame([64, 64], 0.0);
    let tracer = FragmentTracer::new(shown(frame, &[wall])).unwrap();
    for size in [1e-3, 1e-7, 1e-10, 1e-14, 1e-30] {
        let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * size, DVec3::Y * size);
        for (x, y) in (0..6).flat_map(|x| (0..6).map(move |y| (9 * x + 8, 9 * y + 9))) {
            for within in [[0.0, 0.0], [0.0, 0.4], [0.6, 0.0], [1e-9, 1.0 - 1e-9], [0.25, 0.5]] {
                let place = [f64::from(x) + within[0], f64::from(y) + within[1]];
                let receiver = frame.unproject(place[0], place[1], 5.0);
                let Ok(lit) = tracer.visibility(receiver, &light, 3);
                assert_eq!(lit, 0.0, "{place:?} {size}");
            }
        }
    }
}
