//! Properties of coherent sampling, against plain sampling of the same cells.

use std::convert::Infallible;

use dsm_core::detail::Occlusion;
use dsm_core::{
    AreaLight, Facing, LightVisibility, OcclusionTracer, Rgb, ShadedPoint, Transmittance,
};
use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::coherent_shadow::CoherentShadow;
use super::light_cells::LightCells;
use super::settings::CoherenceSettings;
use crate::light_mean::LightMean;

/// Balls, each of which takes a share of the light.
#[derive(Clone, Debug)]
struct Balls<T> {
    balls: Vec<(DVec3, f64, T)>,
    /// Whether it tells where rays are blocked.
    tells: bool,
}

impl<T: Transmittance> Balls<T> {
    fn occlusion(&self, from: DVec3, to: DVec3) -> Occlusion<T> {
        let mut met = Occlusion { transmittance: T::CLEAR, blocker: None };
        for &(centre, radius, left) in &self.balls {
            let way = to - from;
            let nearest = ((centre - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
            let point = from + way * nearest;
            if point.distance(centre) < radius {
                let before = met.transmittance;
                let after = |channel| before.channel(channel) * left.channel(channel);
                met.transmittance = T::from_channels(after);
                met.blocker = self.tells.then_some(point);
            }
        }
        met
    }
}

impl<T: Transmittance> OcclusionTracer for Balls<T> {
    type Value = T;
    type Error = Infallible;

    fn transmittance(&self, from: DVec3, to: DVec3, _: f64) -> Result<T, Infallible> {
        Ok(self.occlusion(from, to).transmittance)
    }

    fn occlusions(
        &self,
        receiver: &ShadedPoint,
        targets: &[(DVec3, f64)],
        found: &mut Vec<Occlusion<T>>,
    ) -> Result<(), Infallible> {
        found.extend(targets.iter().map(|&(to, _)| self.occlusion(receiver.position, to)));
        Ok(())
    }
}

fn config(seed: u64) -> ProptestConfig {
    let long = std::env::var_os("DSM_LONG_TESTS").is_some_and(|value| value == "1");
    ProptestConfig {
        cases: if long { 5_000 } else { 96 },
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn balls<T: Transmittance>(lefts: &'static [T]) -> impl Strategy<Value = Balls<T>> {
    let ball = ((-8..8_i8, 1..7_i8, -8..8_i8), 1..5_u8, 0..lefts.len());
    proptest::collection::vec(ball, 0..6).prop_map(move |balls| {
        let ball = |((x, y, z), radius, left): ((i8, i8, i8), u8, usize)| {
            let centre = DVec3::new(x.into(), y.into(), z.into()) * 0.5;
            (centre, f64::from(radius) * 0.25, lefts[left])
        };
        Balls { balls: balls.into_iter().map(ball).collect(), tells: true }
    })
}

fn lights() -> impl Strategy<Value = AreaLight> {
    (0..3_u8, 1..5_u8).prop_map(|(shape, size)| {
        let (centre, size) = (DVec3::Y * 6.0, f64::from(size) * 0.5);
        match shape {
            0 => AreaLight::rectangle(centre, DVec3::X * size, DVec3::Z * 0.5 * size),
            1 => AreaLight::disk(centre, DVec3::X * size, DVec3::Z * 0.5 * size),
            _ => AreaLight::sphere(centre, size),
        }
    })
}

/// `side` × `side` points of the ground, row by row.
fn ground(side: u32, width: f64) -> Vec<ShadedPoint> {
    let at = |index: u32| (f64::from(index) / f64::from(side) - 0.5) * width;
    (0..side * side)
        .map(|index| ShadedPoint {
            position: DVec3::new(at(index % side), 0.0, at(index / side)),
            facing: Facing::Light,
            seed: u64::from(index),
        })
        .collect()
}

fn values<O: OcclusionTracer<Error = Infallible>>(
    shadow: &CoherentShadow<O>,
    points: &[ShadedPoint],
    light: &AreaLight,
) -> Vec<O::Value> {
    let mut values = Vec::new();
    let Ok(()) = shadow.visibilities(points, light, &mut values);
    values
}

/// Each cell's sample traced, one after the other.
fn plain<O: OcclusionTracer<Error = Infallible>>(
    tracer: &O,
    side: u32,
    points: &[ShadedPoint],
    light: &AreaLight,
) -> Vec<O::Value> {
    let mut cells = LightCells::new(side);
    points
        .iter()
        .map(|point| {
            cells.sample(point.position, light, point.seed);
            let mut mean = LightMean::new();
            for &(target, time) in cells.targets() {
                let Ok(left) = tracer.transmittance(point.position, target, time);
                mean.add(left);
            }
            mean.of(side * side)
        })
        .collect()
}

fn bits<T: Transmittance>(values: &[T]) -> Vec<u32> {
    let channels =
        |value: &T| (0..T::CHANNELS).map(|c| value.channel(c).to_bits()).collect::<Vec<_>>();
    values.iter().flat_map(channels).collect()
}

fn rmse<T: Transmittance>(a: &[T], b: &[T]) -> f64 {
    let off = |(a, b): (&T, &T)| {
        (0..T::CHANNELS).map(|c| f64::from(a.channel(c) - b.channel(c)).powi(2)).sum::<f64>()
    };
    (a.iter().zip(b).map(off).sum::<f64>() / (a.len() * T::CHANNELS) as f64).sqrt()
}

const MONO: &[f32] = &[0.0, 0.0, 0.5];
const RGB: &[Rgb] = &[Rgb::new(0.0, 0.0, 0.0), Rgb::new(0.0, 1.0, 0.5)];

proptest! {
    #![proptest_config(config(71))]

    /// Every cell forced into the list of those to be traced.
    #[test]
    fn without_prediction_it_is_plain_sampling(scene in balls(MONO), coloured in balls(RGB),
        light in lights(), side in 1..9_u32)
    {
        let points = ground(6, 6.0);
        let settings = CoherenceSettings::new(side).with_prediction(false);
        let shadow = CoherentShadow::new(&scene, settings);
        let want = plain(&scene, side, &points, &light);
        prop_assert_eq!(bits(&values(&shadow, &points, &light)), bits(&want));
        let counted = shadow.statistics();
        prop_assert_eq!((counted.rays, counted.fresh, counted.mispredicted), (counted.cells, 36, 0));
        let shadow = CoherentShadow::new(&coloured, settings);
        let want = plain(&coloured, side, &points, &light);
        prop_assert_eq!(bits(&values(&shadow, &points, &light)), bits(&want));
        // A receiver alone, and one too far from the one before, are sampled so as well.
        let shadow = CoherentShadow::new(&scene, CoherenceSettings::new(side));
        let far = CoherentShadow::new(&scene, CoherenceSettings::new(side).with_reach(0.0));
        let want = plain(&scene, side, &points, &light);
        prop_assert_eq!(bits(&values(&far, &points, &light)), bits(&want));
        for (point, want) in points.iter().zip(want) {
            let Ok(alone) = shadow.visibility(point.position, &light, point.seed);
            prop_assert_eq!(alone.to_bits(), want.to_bits());
        }
    }

    #[test]
    fn the_order_of_receivers_does_not_matter(scene in balls(MONO), light in lights(), turn in 1..399_usize) {
        let points = ground(20, 6.0);
        let shadow = CoherentShadow::new(&scene, CoherenceSettings::new(8));
        let want = values(&shadow, &points, &light);
        let mut shuffled = points;
        shuffled.rotate_left(turn);
        shuffled.reverse();
        let mut found = values(&shadow, &shuffled, &light);
        found.reverse();
        found.rotate_right(turn);
        prop_assert_eq!(bits(&found), bits(&want));
    }

    /// On a ground that is sampled densely, little is missed, and much is saved.
    #[test]
    fn dense_receivers_are_answered_nearly_as_plain_ones(scene in balls(MONO), light in lights()) {
        let points = ground(48, 3.0);
        let shadow = CoherentShadow::new(&scene, CoherenceSettings::new(12));
        let want = plain(&scene, 12, &points, &light);
        let off = rmse(&values(&shadow, &points, &light), &want);
        prop_assert!(off <= 0.004, "{}", off);
        let counted = shadow.statistics();
        prop_assert!(counted.fresh < 200, "{:?}", counted);
        // 44 of 144 cells lie at the border.
        prop_assert!(counted.rays < counted.cells, "{:?}", counted);
    }

    /// A tracer that does not tell where: what was seen last is predicted.
    #[test]
    fn unknown_blockers_are_taken_to_stay(scene in balls(&[0.0_f32]), light in lights()) {
        let points = ground(48, 3.0);
        let silent = Balls { tells: false, ..scene.clone() };
        let unknown = CoherentShadow::new(&silent, CoherenceSettings::new(8));
        let want = plain(&scene, 8, &points, &light);
        let off = rmse(&values(&unknown, &points, &light), &want);
        prop_assert!(off <= 0.006, "{}", off);
    }
}

#[test]
fn no_receiver_and_no_area_are_answered() {
    let scene = Balls { balls: vec![(DVec3::Y, 0.5, 0.0_f32)], tells: true };
    let shadow = CoherentShadow::new(&scene, CoherenceSettings::new(4));
    let point = AreaLight::point(DVec3::Y * 6.0);
    assert!(values(&shadow, &[], &point).is_empty());
    let found = values(&shadow, &ground(2, 40.0), &point);
    assert_eq!(found, [1.0, 1.0, 1.0, 0.0]);
    assert_eq!(shadow.statistics().rays, 4);
    let flat = AreaLight::rectangle(DVec3::Y * 6.0, DVec3::ZERO, DVec3::Z);
    let found = values(&shadow, &ground(2, 40.0), &flat);
    assert_eq!(found, [1.0, 1.0, 1.0, 0.0]);
    let nowhere = [DVec3::NAN, DVec3::INFINITY].map(|position| ShadedPoint {
        position,
        facing: Facing::Light,
        seed: 0,
    });
    let light = AreaLight::rectangle(DVec3::Y * 6.0, DVec3::X, DVec3::Z);
    assert_eq!(values(&shadow, &nowhere, &light), [1.0; 2]);
}

/// Figure 9 a: a ball whose shadow falls between two receivers is not seen by rays to
/// the light's border; a receiver on its shadow's edge finds it.
#[test]
fn missed_blockers_are_found_by_denser_receivers() {
    let ball = (DVec3::Y, 0.05, 0.0_f32);
    let scene = Balls { balls: vec![ball], tells: true };
    let light = AreaLight::rectangle(DVec3::Y * 6.0, DVec3::X, DVec3::Z);
    let off = |side: u32| {
        let points = ground(side, 3.0);
        let shadow = CoherentShadow::new(&scene, CoherenceSettings::new(16).with_reach(1.0));
        rmse(&values(&shadow, &points, &light), &plain(&scene, 16, &points, &light))
    };
    let (sparse, dense) = (off(6), off(96));
    assert!(sparse > 0.005, "{sparse}");
    assert!(dense < 0.1 * sparse, "{dense} {sparse}");
}
