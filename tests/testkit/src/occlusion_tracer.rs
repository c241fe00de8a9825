//! Tracers of single rays.

use std::fmt::Debug;

use dsm_core::{Facing, OcclusionTracer, ShadedPoint, Transmittance};
use glam::DVec3;

use crate::agreement::Agreement;
use crate::answers::check_answers;
use crate::disagreement::Disagreement;
use crate::trial::Trial;

/// Checks a tracer: `make` builds it from the scene of a trial, which has this radius
/// before it is placed; it traces `rays`, each from a receiver to a light at a time,
/// placed like the scene.
///
/// Transmittances lie in [0, 1]. They are the same bits whatever the tiles and threads
/// that the tracer is made with, and agree wherever the scene stands and however large
/// it is. A ray alone and one among others of its receiver are answered alike, and
/// blockers lie on their rays.
///
/// ```
/// use dsm_core::OcclusionTracer;
/// use dsm_testkit::{Agreement, Trial, check_occlusion_tracer};
/// use glam::DVec3;
///
/// /// A ball.
/// struct Ball(DVec3, f64);
///
/// impl OcclusionTracer for Ball {
///     type Value = f32;
///     type Error = std::convert::Infallible;
///
///     fn transmittance(&self, from: DVec3, to: DVec3, _: f64) -> Result<f32, Self::Error> {
///         let (way, towards) = (to - from, self.0 - from);
///         let nearest = towards - way * (towards.dot(way) / way.length_squared()).clamp(0.0, 1.0);
///         Ok(if nearest.length() < self.1 { 0.0 } else { 1.0 })
///     }
/// }
///
/// let make = |trial: &Trial| {
///     Ball(trial.placement.point(DVec3::ZERO), trial.placement.scale())
/// };
/// let rays = [(DVec3::X * 3.0, DVec3::X * -4.0, 0.0), (DVec3::X * 3.0, DVec3::Y * 9.0, 0.0)];
/// check_occlusion_tracer(make, 3.0, &rays, &Agreement::default())?;
/// # Ok::<(), dsm_testkit::Disagreement>(())
/// ```
///
/// # Errors
///
/// The first trial whose answers are wrong, and what is wrong with them.
pub fn check_occlusion_tracer<V>(
    make: impl Fn(&Trial) -> V + Sync,
    radius: f64,
    rays: &[(DVec3, DVec3, f64)],
    agreement: &Agreement,
) -> Result<(), Disagreement>
where
    V: OcclusionTracer,
    V::Error: Debug,
{
    check_answers(radius, agreement, |trial| answers(&make(trial), trial, rays))
}

/// Checks that a ray alone and among others of its receiver is answered with the same
/// bits, and that what blocks it lies on it.
fn check_occlusion<V>(
    tracer: &V,
    [receiver, light]: [DVec3; 2],
    time: f64,
    left: V::Value,
) -> Result<(), String>
where
    V: OcclusionTracer,
    V::Error: Debug,
{
    let point = ShadedPoint { position: receiver, facing: Facing::Light, seed: 0 };
    let mut found = Vec::new();
    let targets = [(receiver, time), (light, time)];
    let traced = tracer.occlusions(&point, &targets, &mut found);
    traced.map_err(|error| format!("no occlusions: {error:?}"))?;
    let [_, met] = found.as_slice() else {
        return Err(format!("{} occlusions for 2 rays", found.len()));
    };
    let bits = |value: V::Value| (0..V::Value::CHANNELS).map(move |c| value.channel(c).to_bits());
    if !bits(met.transmittance).eq(bits(left)) {
        return Err(format!("{left:?} alone, {:?} among others", met.transmittance));
    }
    let way = light - receiver;
    let slack = 1e-6 * way.length() + 1e-9 * receiver.abs().max(light.abs()).max_element();
    let off = met.blocker.map_or(0.0, |blocker| {
        let along = (blocker - receiver).dot(way) / way.length_squared();
        blocker.distance(receiver + way * along.clamp(0.0, 1.0))
    });
    if off <= slack { Ok(()) } else { Err(format!("a blocker {off} beside its ray")) }
}

/// The transmittance of every ray, channel after channel.
fn answers<V>(tracer: &V, trial: &Trial, rays: &[(DVec3, DVec3, f64)]) -> Result<Vec<f64>, String>
where
    V: OcclusionTracer,
    V::Error: Debug,
{
    let mut answers = Vec::new();
    for &(receiver, light, time) in rays {
        let [receiver, light] = [receiver, light].map(|point| trial.placement.point(point));
        let left = tracer.transmittance(receiver, light, time);
        let left = left.map_err(|error| format!("no answer: {error:?}"))?;
        check_occlusion(tracer, [receiver, light], time, left)?;
        for channel in 0..V::Value::CHANNELS {
            let left = f64::from(left.channel(channel));
            if !(0.0..=1.0).contains(&left) {
                return Err(format!("answer {} is {left}", answers.len()));
            }
            answers.push(left);
        }
    }
    Ok(answers)
}
