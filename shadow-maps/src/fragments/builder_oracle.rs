//! Building maps of fragments as naively as can be, and what the builder is
//! compared with.

use dsm_core::{
    Error, HitSource, Progress, Rgb, ShadowCamera, SurfaceHit, TileHits, TileSamples, Transmittance,
};
use dsm_testkit::config;
use glam::{DMat4, DVec4, Vec3};
use proptest::prelude::*;

use super::builder::FragmentBuilder;
use super::fragment::Fragment;

/// One surface in the way of a sample.
#[derive(Clone, Copy, Debug)]
struct Met<T> {
    pixel: [u32; 2],
    sample: u32,
    depth: f32,
    opacity: T,
    normal: Option<Vec3>,
}

/// Hits in some order.
struct Scattered<T>(Vec<Met<T>>);

impl<T: Transmittance> HitSource<T> for Scattered<T> {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), Error> {
        let per_pixel = samples.samples_per_pixel();
        for met in &self.0 {
            let of_pixel = |&first: &u32| {
                let place = [samples.x(), samples.y()].map(|column| column[first as usize] as u32);
                place == met.pixel
            };
            let firsts = (0..samples.len()).step_by(per_pixel as usize);
            let Some(first) = { firsts }.find(of_pixel) else { continue };
            let hit = SurfaceHit { depth: met.depth, opacity: met.opacity };
            match met.normal {
                Some(normal) => hits.push_surface_with_normal(first + met.sample, hit, normal)?,
                None => hits.push_surface(first + met.sample, hit)?,
            }
        }
        Ok(())
    }

    /// It knows hits by their sample, of as many as there are in a mask.
    fn has_media(&self) -> bool {
        false
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

const SIZE: [u32; 2] = [18, 2];
const LIGHT_DEPTH: f64 = 0.5;

/// One hit of a group, with all that is compared.
#[derive(Clone, Copy, Debug)]
struct Hit<T> {
    w: f64,
    met: Met<T>,
    gradient: Option<[f64; 2]>,
}

/// The fragments of a pixel, and whether there were more: every hit is compared
/// with every group.
fn naive<T: Transmittance>(
    builder: &FragmentBuilder,
    met: &[Met<T>],
    pixel: [u32; 2],
) -> (Vec<Fragment<T>>, bool) {
    let side = builder.coverage();
    let within = |sample: u32| {
        [sample % side, sample / side].map(|at| (f64::from(at) + 0.5) / f64::from(side))
    };
    let frame = builder.frame();
    let is_here = |met: &&Met<T>| met.pixel == pixel && f64::from(met.depth) > LIGHT_DEPTH;
    let mut hits: Vec<Hit<T>> = met
        .iter()
        .filter(is_here)
        .map(|&met| {
            let [x, y] = within(met.sample);
            let (x, y) = (x + f64::from(pixel[0]), y + f64::from(pixel[1]));
            let depth = f64::from(met.depth);
            let plane = |normal: Vec3| frame.plane(x, y, depth, normal.as_dvec3());
            Hit { w: depth.recip(), met, gradient: met.normal.and_then(plane) }
        })
        .collect();
    hits.sort_by(|a, b| {
        let opacity = |hit: &Hit<T>| {
            (0..T::CHANNELS).map(|channel| hit.met.opacity.channel(channel)).collect::<Vec<_>>()
        };
        let order = a.w.partial_cmp(&b.w).unwrap().then(a.met.sample.cmp(&b.met.sample));
        order
            .then(opacity(a).partial_cmp(&opacity(b)).unwrap())
            .then(a.gradient.is_some().cmp(&b.gradient.is_some()))
            .then_with(|| {
                let bits = |hit: &Hit<T>| hit.gradient.map(|along| along.map(f64::to_bits));
                bits(a).cmp(&bits(b))
            })
    });
    let squares = |sample: u32| {
        (0..64_u32)
            .filter(|at| {
                let [column, row] = [at % 8 * side / 8, at / 8 * side / 8];
                row * side + column == sample
            })
            .fold(0_u64, |bits, at| bits | 1 << at)
    };
    let fits = |first: &Hit<T>, hit: &Hit<T>| {
        let near = |sides: f64| sides * frame.footprint(1.0) * first.w.max(hit.w);
        let (from, to) = (within(first.met.sample), within(hit.met.sample));
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let off = |[x, y]: [f64; 2]| (hit.w - first.w - (x * dx + y * dy)).abs();
        first.met.opacity == hit.met.opacity
            && match (first.gradient, hit.gradient) {
                (None, None) => hit.w - first.w <= near(0.2),
                (Some(a), Some(b)) => off(a) <= near(0.01) && off(b) <= near(0.01),
                _ => false,
            }
    };
    let mut groups: Vec<(Hit<T>, f64, u64)> = Vec::new();
    for hit in &hits {
        let bit = squares(hit.met.sample);
        let joins = |group: &&mut (Hit<T>, f64, u64)| group.2 & bit == 0 && fits(&group.0, hit);
        match groups.iter_mut().rev().find(joins) {
            Some(group) => (group.1, group.2) = (hit.w, group.2 | bit),
            None => groups.push((*hit, hit.w, bit)),
        }
    }
    let is_cut = groups.len() > builder.layers() as usize;
    let fragment = |(first, _, coverage): &(Hit<T>, f64, u64)| {
        let [x, y] = within(first.met.sample);
        let (w, gradient) = match first.gradient {
            Some(along) => (
                first.w + along[0] * (0.5 - x) + along[1] * (0.5 - y),
                Some(along.map(|along| along as f32 + 0.0)),
            ),
            None => (first.w, None),
        };
        Fragment { w: w as f32, gradient, opacity: first.met.opacity, coverage: *coverage }
    };
    (groups.iter().map(fragment).collect(), is_cut)
}

/// The light that gets past all fragments of a pixel, in the mean over its squares.
fn behind<T: Transmittance>(list: &[Fragment<T>], channel: usize) -> f64 {
    let square = |square: u32| -> f64 {
        let some = list.iter().filter(|one| one.coverage >> square & 1 == 1);
        some.map(|one| 1.0 - f64::from(one.opacity.channel(channel))).product()
    };
    (0..64).map(square).sum::<f64>() / 64.0
}

/// All of a fragment, in an order.
fn bits<T: Transmittance>(fragment: &Fragment<T>) -> (u32, u64, Vec<u32>, Option<[u32; 2]>) {
    let opacity = (0..T::CHANNELS).map(|channel| fragment.opacity.channel(channel).to_bits());
    let gradient = fragment.gradient.map(|gradient| gradient.map(f32::to_bits));
    (fragment.w.to_bits(), fragment.coverage, opacity.collect(), gradient)
}

fn check<T: Transmittance>(
    mut met: Vec<Met<T>>,
    side: u32,
    layers: u32,
) -> Result<(), TestCaseError> {
    met.iter_mut().for_each(|met| met.sample %= side * side);
    let builder = FragmentBuilder::new(camera(), SIZE, LIGHT_DEPTH).unwrap();
    let builder = builder.with_coverage(side).unwrap().with_layers(layers).unwrap();
    let (map, counts) =
        builder.build_counted(&Scattered(met.clone()), Progress::ignore).unwrap().unwrap();
    let mut cut_pixels = 0;
    for pixel in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y])) {
        let (mut expected, is_cut) = naive(&builder, &met, pixel);
        cut_pixels += u64::from(is_cut);
        let found: Vec<_> = map.pixel(pixel[0], pixel[1]).collect();
        prop_assert!(found.is_sorted_by(|a, b| a.w <= b.w));
        if is_cut {
            // The nearest stay, the farthest keeps its place, and the light behind all.
            expected.sort_by(|a, b| {
                let key = |one: &Fragment<T>| (one.coverage, one.opacity.channel(0).to_bits());
                a.w.total_cmp(&b.w).then_with(|| key(a).cmp(&key(b)))
            });
            prop_assert_eq!(found.len(), layers as usize);
            let nearest = expected.len() + 1 - found.len();
            prop_assert_eq!(&found[1..], &expected[nearest..]);
            prop_assert_eq!(found[0].w, expected[0].w);
            for channel in 0..T::CHANNELS {
                let [have, want] = [&found, &expected].map(|list| behind(list, channel));
                prop_assert!((have - want).abs() < 1e-5, "{} {}", have, want);
            }
            continue;
        }
        let mut found: Vec<_> = found.iter().map(bits).collect();
        found.sort();
        expected.sort_by_key(bits);
        prop_assert_eq!(found, expected.iter().map(bits).collect::<Vec<_>>());
    }
    prop_assert_eq!(counts.hits, met.len() as u64);
    prop_assert_eq!(counts.cut_pixels, cut_pixels);
    // The order in which things are found does not show.
    met.reverse();
    prop_assert_eq!(&builder.build(&Scattered(met)).unwrap(), &map);
    Ok(())
}

/// Hits of few pixels and samples, at depths that often agree.
fn met<T: Transmittance>(opacity: impl Strategy<Value = T>) -> impl Strategy<Value = Vec<Met<T>>> {
    let depth = prop_oneof![
        3 => (1_u32..9).prop_map(|half| half as f32 * 0.5),
        // A hundredth of a pixel's side apart, and more.
        2 => (0_i32..60).prop_map(|step| 3.0 + 0.0009 * step as f32),
        1 => 0.1_f32..6.0,
    ];
    let normal = prop_oneof![
        2 => Just(None),
        2 => Just(Some(Vec3::Z)),
        1 => (-1.0_f32..1.0, -1.0_f32..1.0).prop_map(|(x, y)| Some(Vec3::new(x, y, 0.5))),
    ];
    let pixel = (prop_oneof![0_u32..2, 15_u32..18], 0_u32..2);
    let met = (pixel, 0_u32..64, depth, opacity, normal).prop_map(
        |((x, y), sample, depth, opacity, normal)| Met {
            pixel: [x, y],
            sample,
            depth,
            opacity,
            normal,
        },
    );
    proptest::collection::vec(met, 0..400)
}

fn side() -> impl Strategy<Value = u32> {
    prop_oneof![Just(1_u32), Just(2), Just(4), Just(8)]
}

fn layers() -> impl Strategy<Value = u32> {
    prop_oneof![Just(FragmentBuilder::MAX_LAYERS), 1_u32..12]
}

proptest! {
    #![proptest_config(config(41))]

    #[test]
    fn a_map_holds_what_every_pixel_meets(
        met in met(prop_oneof![Just(0.5_f32), Just(1.0)]), side in side(), layers in layers())
    {
        check(met, side, layers)?;
    }

    #[test]
    fn colours_are_kept_apart(
        met in met(prop_oneof![
            Just(Rgb::new(0.5, 0.0, 1.0)), Just(Rgb::new(0.5, 1.0, 0.0)), Just(Rgb::new(0.5, 0.5, 0.5))
        ]),
        side in side(), layers in layers())
    {
        check(met, side, layers)?;
    }
}
