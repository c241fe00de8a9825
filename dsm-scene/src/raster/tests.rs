//! The rasteriser against the naive answers.

use dsm_core::{
    HitSource, PixelSampling, Rgb, SamplePoint, ShadowCamera, TileHits, TileSamples, Transmittance,
};
use dsm_testkit::config;
use fearless_simd::Level;
use glam::Vec3;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::oracle::{self, Expected, Ray, orthographic, perspective};
use super::rasterizer::{Rasterizer, RasterizerBuilder};
use super::segment::Segment;

const SIZE: [u32; 2] = [40, 30];

/// The scene of a test: primitives where the shutter opens and closes.
#[derive(Clone, Debug)]
struct Scene {
    segments: Vec<[Segment; 2]>,
    triangles: Vec<[[Vec3; 3]; 2]>,
    moving: bool,
}

impl Scene {
    /// With an opacity of its own for every primitive, or one for each kind.
    fn rasterizer(&self, camera: &ShadowCamera, distinct: bool) -> Rasterizer<f32> {
        let mut builder = RasterizerBuilder::new(camera, SIZE).unwrap();
        for (index, keys) in self.segments.iter().enumerate() {
            let opacity = opacity(index, distinct);
            if self.moving {
                builder.moving_segments(opacity, [*keys]).unwrap();
            } else {
                builder.segments(opacity, [keys[0]]).unwrap();
            }
        }
        for (index, keys) in self.triangles.iter().enumerate() {
            let opacity = opacity(index, distinct) + 0.5;
            if self.moving {
                builder.moving_triangles(opacity, [*keys]).unwrap();
            } else {
                builder.triangles(opacity, [keys[0]]).unwrap();
            }
        }
        builder.build().unwrap()
    }

    /// The outcomes of a ray against all primitives, with their opacities.
    fn naive(&self, ray: &Ray, point: SamplePoint, distinct: bool) -> Vec<(f32, Expected)> {
        let time = if self.moving { point.time } else { 0.0 };
        let segments = self
            .segments
            .iter()
            .enumerate()
            .map(|(index, keys)| (opacity(index, distinct), oracle::segment(ray, keys, time)));
        let triangles = self.triangles.iter().enumerate().map(|(index, keys)| {
            (opacity(index, distinct) + 0.5, oracle::triangle(ray, keys, time))
        });
        segments.chain(triangles).collect()
    }
}

fn opacity(index: usize, distinct: bool) -> f32 {
    if distinct { (index + 1) as f32 / 1024.0 } else { 0.25 }
}

/// Bits of depth and opacity of all hits of a block, sample by sample.
fn found(rasterizer: &Rasterizer<f32>, samples: &TileSamples) -> Vec<Vec<(u32, u32)>> {
    let mut hits = TileHits::new(samples.len());
    rasterizer.hits(samples, &mut hits).unwrap();
    let mut found = vec![Vec::new(); samples.len() as usize];
    for (sample, hit) in hits.surfaces() {
        found[sample as usize].push((hit.depth.to_bits(), hit.opacity.to_bits()));
    }
    found
}

/// The number of hits that were certain.
fn check(scene: &Scene, camera: &ShadowCamera, samples: &TileSamples, distinct: bool) -> usize {
    let found = found(&scene.rasterizer(camera, distinct), samples);
    let mut sure = 0;
    for (index, point) in (0..).zip(samples.points()) {
        let ray = Ray::new(camera, SIZE, point);
        let mut left = found[index].clone();
        let expected = scene.naive(&ray, point, distinct);
        for &(opacity, met) in &expected {
            let Expected::Hit(depth, blur) = met else { continue };
            let close = |&(bits, of): &(u32, u32)| {
                of == opacity.to_bits() && (f64::from(f32::from_bits(bits)) - depth).abs() <= blur
            };
            let at = left.iter().position(close);
            let at = at.unwrap_or_else(|| panic!("{point:?} {opacity} {met:?} not in {left:?}"));
            left.swap_remove(at);
            sure += 1;
        }
        for (bits, of) in left {
            let grazed = |&&(opacity, met): &&(f32, Expected)| {
                opacity.to_bits() == of && met == Expected::Uncertain
            };
            assert!(
                expected.iter().any(|one| grazed(&one)),
                "{point:?}: none at {}, {expected:?}",
                f32::from_bits(bits)
            );
        }
    }
    sure
}

/// Points in and around the view of the cameras, behind them too.
fn point() -> impl Strategy<Value = Vec3> {
    let grid = (-4_i8..=4, -4_i8..=4, -8_i8..=1)
        .prop_map(|(x, y, z)| Vec3::new(f32::from(x), f32::from(y), f32::from(z)) / 2.0);
    let any =
        (-3.0_f32..3.0, -3.0_f32..3.0, -6.0_f32..1.0).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    prop_oneof![1 => grid, 3 => any]
}

fn segment() -> impl Strategy<Value = Segment> {
    let radius = || select(vec![0.0_f32, 1e-4, 0.01, 0.05, 0.3]);
    let near =
        (-0.3_f32..0.3, -0.3_f32..0.3, -0.3_f32..0.3).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    let second = prop_oneof![
        4 => near.prop_map(|offset| (offset, Vec3::ZERO)),
        1 => point().prop_map(|point| (Vec3::ZERO, point)),
        1 => Just((Vec3::ZERO, Vec3::ZERO)),
    ];
    let ends = (point(), second, radius(), radius(), any::<bool>());
    ends.prop_map(|(first, (offset, other), start, end, is_joined)| {
        let second = if other == Vec3::ZERO { first + offset } else { other };
        Segment { ends: [first, second], radii: [start, end], is_joined }
    })
}

fn scene() -> impl Strategy<Value = Scene> {
    let triangle = || [point(), point(), point()];
    let shift = || prop_oneof![Just(0.0_f32), -0.2_f32..0.2, -2.0_f32..2.0];
    let shift = (shift(), shift(), shift()).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    let segments = vec((segment(), segment(), any::<bool>()), 0..40);
    let triangles = vec((triangle(), triangle(), any::<bool>()), 0..6);
    (segments, triangles, shift, any::<bool>()).prop_map(|(segments, triangles, shift, moving)| {
        // Some move as a whole, some turn into another.
        let segments = segments.into_iter().map(|(open, close, apart)| {
            let along = Segment { ends: open.ends.map(|end| end + shift), ..open };
            let close = Segment { is_joined: open.is_joined, ..close };
            [open, if apart { close } else { along }]
        });
        let triangles = triangles.into_iter().map(|(open, close, apart)| {
            [open, if apart { close } else { open.map(|corner| corner + shift) }]
        });
        Scene { segments: segments.collect(), triangles: triangles.collect(), moving }
    })
}

fn any_camera() -> impl Strategy<Value = ShadowCamera> {
    let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
    prop_oneof![
        Just(perspective(90.0, aspect)),
        Just(perspective(20.0, aspect)),
        Just(orthographic(4.0, aspect)),
    ]
}

/// A block within, across or beyond the border of the map.
fn block() -> impl Strategy<Value = TileSamples> {
    let per_pixel = select(vec![1_u32, 2, 4, 7, 16, 64]);
    (per_pixel, -30_i32..60, -30_i32..50, 1_u32..12, 1_u32..12, any::<u64>()).prop_map(
        |(per_pixel, x, y, width, height, seed)| {
            let sampling = PixelSampling::new(per_pixel, seed).unwrap();
            let area = width * height * per_pixel;
            let height = if area > 1000 { 1 + 1000 / (width * per_pixel) } else { height };
            TileSamples::new(&sampling, [x, y], [width, height.min(12)], None).unwrap()
        },
    )
}

proptest! {
    #![proptest_config(config(1))]

    #[test]
    fn hits_are_those_of_a_naive_search(
        scene in scene(), camera in any_camera(), samples in block(), distinct: bool,
    ) {
        check(&scene, &camera, &samples, distinct);
    }

    /// Whatever the block, and the processor.
    #[test]
    fn a_pixel_is_answered_the_same_way_in_every_block(
        scene in scene(), camera in any_camera(), per_pixel in select(vec![1_u32, 4, 7, 16]),
        x in 0_u32..20, y in 0_u32..20,
    ) {
        let sampling = PixelSampling::new(per_pixel, 1).unwrap();
        let whole = TileSamples::new(&sampling, [-4, -2], [20, 20], None).unwrap();
        let one = [x as i32 - 4, y as i32 - 2];
        let one = TileSamples::new(&sampling, one, [1, 1], None).unwrap();
        let rasterizer = scene.rasterizer(&camera, true);
        let all = found(&rasterizer, &whole);
        let samples = whole.pixel(x, y);
        let of_pixel = &all[samples.start as usize..samples.end as usize];
        prop_assert_eq!(of_pixel, &found(&rasterizer, &one)[..]);

        let level = Level::new();
        let levels = [
            level.as_avx2().map(Level::Avx2),
            level.as_sse4_2().map(Level::Sse4_2),
            Some(Level::baseline()),
        ];
        for level in levels.into_iter().flatten() {
            let rasterizer = scene.rasterizer(&camera, true).with_level(level);
            prop_assert_eq!(&found(&rasterizer, &whole), &all, "{:?}", level);
        }
    }

    /// Two triangles of a fan or a square: rays through the edge between them
    /// meet one.
    #[test]
    fn shared_edges_are_met_once(
        corners in prop::array::uniform4((-3_i8..=3, -3_i8..=3)), turned: bool, swapped: bool,
    ) {
        let [a, b, c, d] = corners.map(|(x, y)| Vec3::new(f32::from(x), f32::from(y), -2.0));
        let side = |point: Vec3| (b - a).cross(point - a).z;
        // One on either side of the edge, or mirrored in its middle to be there.
        let c = if side(c) > 0.0 { c } else { a + b - c };
        let d = if side(d) < 0.0 { d } else { a + b - d };
        prop_assume!(side(c) > 0.0 && side(d) < 0.0);
        let (mut one, mut other) = ([a, b, c], [b, a, d]);
        if turned { one.swap(0, 1); }
        if swapped { other.rotate_left(1); }
        // Centres lie on multiples of ¼.
        let camera = orthographic(8.0, 1.0);
        let samples = TileSamples::new(&PixelSampling::centre(), [0, 0], [32, 32], None).unwrap();
        let count = |triangles: &[[Vec3; 3]]| {
            let mut builder = RasterizerBuilder::new(&camera, [32, 32]).unwrap();
            builder.triangles(1.0, triangles.iter().copied()).unwrap();
            let mut hits = vec![0; 1024];
            for (sample, found) in found(&builder.build().unwrap(), &samples).iter().enumerate() {
                hits[sample] = found.len();
            }
            hits
        };
        let both = count(&[one, other]);
        let inside = |point: Vec3| {
            // The edge itself, without its ends.
            side(point) == 0.0 && (point - a).dot(b - a) > 0.0 && (point - b).dot(a - b) > 0.0
        };
        for (index, point) in samples.points().enumerate() {
            let point = Vec3::new(point.x as f32 / 4.0 - 4.0, 4.0 - point.y as f32 / 4.0, -2.0);
            if inside(point) {
                prop_assert_eq!(both[index], 1, "{}", point);
            }
        }
    }
}

fn strand(ends: [Vec3; 2], radius: f32) -> Segment {
    Segment { ends, radii: [radius; 2], is_joined: false }
}

#[test]
fn the_naive_search_finds_much() {
    // A test above that never met anything would pass.
    let mut sure = 0;
    for camera in [perspective(90.0, 1.5), orthographic(4.0, 1.5)] {
        for per_pixel in [1, 4, 7, 16, 64] {
            let sampling = PixelSampling::new(per_pixel, 5).unwrap();
            let samples = TileSamples::new(&sampling, [-3, 5], [9, 7], None).unwrap();
            let segments = (0..30).map(|index| {
                let at = index as f32 / 10.0 - 1.5;
                let still = strand([Vec3::new(-3.0, at, -2.0), Vec3::new(3.0, -at, -4.0)], 0.02);
                let moved = strand(still.ends.map(|end| end + Vec3::X * 0.1), 0.03);
                [still, moved]
            });
            for moving in [false, true] {
                let scene =
                    Scene { segments: segments.clone().collect(), triangles: Vec::new(), moving };
                sure += check(&scene, &camera, &samples, true);
            }
        }
    }
    assert!(sure > 5000, "{sure}");
}

#[test]
fn a_strand_is_met_once_a_crossing_however_it_is_cut() {
    let samples =
        TileSamples::new(&PixelSampling::new(16, 1).unwrap(), [0, 0], SIZE, None).unwrap();
    let (from, to) = (Vec3::new(-1.5, -0.2, -2.0), Vec3::new(1.4, 0.3, -3.5));
    for camera in [perspective(90.0, 1.5), orthographic(4.0, 1.5)] {
        let hits = |pieces: u16| {
            let at = |piece: u16| from.lerp(to, f32::from(piece) / f32::from(pieces));
            let pieces = (0..pieces).map(|piece| Segment {
                is_joined: piece > 0,
                ..strand([at(piece), at(piece + 1)], 0.2)
            });
            let mut builder = RasterizerBuilder::<f32>::new(&camera, SIZE).unwrap();
            builder.segments(0.5, pieces).unwrap();
            let mut hits = TileHits::new(samples.len());
            builder.build().unwrap().hits(&samples, &mut hits).unwrap();
            hits.surface_count()
        };
        let whole = hits(1);
        assert!(whole > 100);
        for pieces in [2, 7, 64, 300] {
            // A point of the cut is rounded: a ray at the rim may tell.
            assert!(hits(pieces).abs_diff(whole) <= 1, "{pieces}: {} {whole}", hits(pieces));
        }
    }
}

#[test]
fn odd_primitives_do_no_harm() {
    let odd = [f32::NAN, f32::INFINITY, -1.0, f32::MAX, 1e18, 0.0];
    let camera = perspective(90.0, 1.5);
    let mut builder = RasterizerBuilder::<Rgb>::new(&camera, SIZE).unwrap();
    let colour = Rgb::new(0.1, 0.2, 0.3);
    for x in odd {
        for z in odd {
            let far = Vec3::new(x, 1.0, z);
            let near = Vec3::new(0.1, 0.2, -1.0);
            let segment = strand([far, near], if z == 0.0 { x } else { 0.1 });
            let triangle = [near, far, Vec3::new(z, x, -z)];
            builder.segments(colour, [segment]).unwrap();
            builder.moving_segments(colour, [[strand([near; 2], 0.1), segment]]).unwrap();
            builder.triangles(colour, [triangle, [near; 3]]).unwrap();
            builder.moving_triangles(colour, [[[near, far, near], triangle]]).unwrap();
        }
    }
    builder.segments(Rgb::splat(0.0), [strand([-Vec3::Z; 2], 0.5)]).unwrap();
    assert!(builder.segments(Rgb::splat(1.5), []).is_err());
    let rasterizer = builder.build().unwrap();
    let sampling = PixelSampling::new(7, 0).unwrap();
    for min in [[0, 0], [i32::MIN, 7], [9, i32::MAX - 41]] {
        let samples = TileSamples::new(&sampling, min, [20, 10], None).unwrap();
        let mut hits = TileHits::new(samples.len());
        rasterizer.hits(&samples, &mut hits).unwrap();
        assert!(hits.surfaces().all(|(_, hit)| hit.opacity == colour && hit.depth > 0.0));
    }
    let limit = RasterizerBuilder::<f32>::new(&camera, [u32::MAX, 1]);
    assert!(limit.is_err());
}

#[test]
fn huge_maps_take_memory_for_their_primitives_only() {
    let camera = orthographic(1.0, 1.0);
    let corners = [[0.5, 0.5], [-0.5, 0.5], [0.0, -0.5]];
    let triangle = corners.map(|[x, y]| Vec3::new(x, y, -1.0));
    let mut builder = RasterizerBuilder::<f32>::new(&camera, [1 << 19; 2]).unwrap();
    builder.triangles(0.5, [triangle; 50]).unwrap();
    let hair = strand([Vec3::new(-0.5, 0.0, -1.0), Vec3::new(0.5, 0.0, -1.0)], 1e-6);
    builder.segments(0.25, [hair]).unwrap();
    let rasterizer = builder.build().unwrap();
    let middle = TileSamples::new(&PixelSampling::centre(), [1 << 18; 2], [1, 1], None).unwrap();
    assert_eq!(found(&rasterizer, &middle)[0].len(), 51);
}
