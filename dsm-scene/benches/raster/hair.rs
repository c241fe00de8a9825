//! A ball of hair over a floor, and the rays of a light's camera.
//!
//! 50,000 curls of 16 segments, a map of 512 × 512 pixels of 16 samples that
//! the ball nearly fills.

use std::f32::consts::TAU;
use std::sync::OnceLock;

use dsm_core::{PixelSampling, ShadowCamera, TileSamples};
use dsm_scene::detail::{Rasterizer, RasterizerBuilder, Segment};
use glam::{DMat4, DVec4, Quat, Vec3};

pub(crate) const SIZE: u32 = 512;
pub(crate) const TILE: u32 = 64;
pub(crate) const SAMPLES: u32 = 16;

/// Pseudo-random numbers in [0, 1).
fn uniform(state: &mut u64) -> f32 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 40) as f32 / 16_777_216.0
}

fn direction(state: &mut u64) -> Vec3 {
    loop {
        let point = Vec3::from_array([(); 3].map(|()| 2.0 * uniform(state) - 1.0));
        if (0.01..1.0).contains(&point.length_squared()) {
            return point.normalize();
        }
    }
}

/// Curls on a ball around the origin which is 1 in radius with them.
fn curls() -> Vec<Segment> {
    let mut state = 3;
    let mut segments = Vec::new();
    for _ in 0..50_000 {
        let out = direction(&mut state);
        let across = out.cross(direction(&mut state)).normalize();
        let around = out.cross(across);
        let mut number = |low: f32, range: f32| low + range * uniform(&mut state);
        let (length, curl) = (number(0.35, 0.1), number(0.02, 0.04));
        let (turn, phase) = (number(2.0, 3.0), number(0.0, TAU));
        let sag = Vec3::new(number(-0.15, 0.3), -0.15, number(-0.15, 0.3));
        let point = |index: u8| {
            let along = f32::from(index) / 16.0;
            let (sin, cos) = (phase + turn * along).sin_cos();
            out * (0.55 + length * along)
                + (across * cos + around * sin) * (curl * along)
                + sag * (along * along)
        };
        segments.extend((0..16).map(|index| Segment {
            ends: [point(index), point(index + 1)],
            radii: [1.0 / 512.0; 2],
            is_joined: index > 0,
        }));
    }
    segments
}

/// A perspective camera of 30 degrees, 5 above the ball's middle.
fn camera() -> ShadowCamera {
    let focal = 0.5 / 15_f64.to_radians().tan();
    let to_ndc = DMat4::from_cols(
        DVec4::new(focal, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -focal, 0.0, 0.0),
        DVec4::new(-0.5, -0.5, 1.0, -1.0),
        DVec4::ZERO,
    );
    ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) }
}

fn to_camera(point: Vec3) -> Vec3 {
    // Slanted, as light falls.
    let to_light = Vec3::new(0.45, 0.85, 0.3).normalize();
    Quat::from_rotation_arc(to_light, Vec3::Z) * point - 5.0 * Vec3::Z
}

pub(crate) fn segments() -> &'static [Segment] {
    static SEGMENTS: OnceLock<Vec<Segment>> = OnceLock::new();
    SEGMENTS.get_or_init(|| {
        let place = |curl: Segment| Segment { ends: curl.ends.map(to_camera), ..curl };
        curls().into_iter().map(place).collect()
    })
}

fn floor() -> [[Vec3; 3]; 2] {
    let corner = |x: f32, z: f32| to_camera(Vec3::new(8.0 * x, -1.1, 8.0 * z));
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    [[a, c, b], [a, d, c]]
}

pub(crate) fn build() -> Rasterizer<f32> {
    let mut builder = RasterizerBuilder::new(&camera(), [SIZE; 2]).expect("a camera");
    builder.segments(0.3, segments().iter().copied()).expect("an opacity");
    builder.triangles(1.0, floor()).expect("an opacity");
    builder.build().expect("few primitives")
}

/// All blocks of the map.
pub(crate) fn blocks() -> Vec<TileSamples> {
    let sampling = PixelSampling::new(SAMPLES, 0).expect("a number of samples");
    let origins = (0..SIZE / TILE).flat_map(|y| (0..SIZE / TILE).map(move |x| [x, y]));
    let block = |origin: [u32; 2]| {
        let min = origin.map(|at| (at * TILE) as i32);
        TileSamples::new(&sampling, min, [TILE; 2], None).expect("a block")
    };
    origins.map(block).collect()
}
