//! Shadow methods.

use std::fmt::Debug;

use dsm_core::{AreaLight, LightVisibility, ShadedPoint, Transmittance};

use crate::agreement::Agreement;
use crate::answers::check_answers;
use crate::disagreement::Disagreement;
use crate::trial::Trial;

/// Checks a shadow method: `make` builds it from the scene of a trial, of this radius
/// before it is placed; it is queried at `points` under `light`, placed like the scene.
///
/// Factors lie in [0, 1]. They are the same bits whatever the tiles and threads that the
/// method is made with and queried on, and whether points come together or one by one; and
/// they agree wherever the scene stands and however large it is.
///
/// ```
/// use dsm_core::{AreaLight, LightVisibility};
/// use dsm_testkit::{Agreement, Placement, Trial, check_light_visibility};
/// use glam::DVec3;
///
/// /// All is lit above a height.
/// struct Above(f64);
///
/// impl LightVisibility for Above {
///     type Value = f32;
///     type Error = std::convert::Infallible;
///
///     fn visibility(&self, at: DVec3, _: &AreaLight, _: u64) -> Result<f32, Self::Error> {
///         Ok(if at.y > self.0 { 1.0 } else { 0.0 })
///     }
/// }
///
/// let points = [0.5, 1.5].map(|y| Placement::receiver(DVec3::Y * y, 0));
/// let light = AreaLight::point(DVec3::Y * 9.0);
/// let check = |make: &(dyn Fn(&Trial) -> Above + Sync)| {
///     check_light_visibility(make, 2.0, &points, &light, &Agreement::default())
/// };
/// assert!(check(&|trial| Above(trial.placement.point(DVec3::Y).y)).is_ok());
/// assert!(check(&|_| Above(1.0)).is_err());
/// ```
///
/// # Errors
///
/// The first trial whose answers are wrong, and what is wrong with them.
pub fn check_light_visibility<V>(
    make: impl Fn(&Trial) -> V + Sync,
    radius: f64,
    points: &[ShadedPoint],
    light: &AreaLight,
    agreement: &Agreement,
) -> Result<(), Disagreement>
where
    V: LightVisibility,
    V::Error: Debug,
{
    check_answers(radius, agreement, |trial| answers(&make(trial), trial, points, light))
}

/// The factors of all points, channel after channel.
fn answers<V>(
    shadow: &V,
    trial: &Trial,
    points: &[ShadedPoint],
    light: &AreaLight,
) -> Result<Vec<f64>, String>
where
    V: LightVisibility,
    V::Error: Debug,
{
    let points: Vec<_> = points.iter().map(|point| trial.placement.shaded(point)).collect();
    let light = trial.placement.light(light);
    let ask = |points: &[ShadedPoint], values: &mut Vec<V::Value>| {
        let done = shadow.visibilities(points, &light, values);
        done.map_err(|error| format!("no answer: {error:?}"))
    };
    let mut together = Vec::new();
    ask(&points, &mut together)?;
    let mut apart = Vec::new();
    // In tiles of points, and the first ones alone.
    let (alone, others) = points.split_at(points.len().min(8));
    for points in alone.chunks(1).chain(others.chunks(trial.tile_size as usize + 1)) {
        ask(points, &mut apart)?;
    }
    let channels = |values: &[V::Value]| -> Vec<f64> {
        let channels = |value: &V::Value| {
            let value = *value;
            (0..V::Value::CHANNELS).map(move |channel| f64::from(value.channel(channel)))
        };
        values.iter().flat_map(channels).collect()
    };
    let [together, apart] = [&together, &apart].map(|values| channels(values));
    if let Some(index) = together.iter().position(|value| !(0.0..=1.0).contains(value)) {
        return Err(format!("answer {index} is {}", together[index]));
    }
    if together != apart {
        return Err("points asked together and apart have other answers".to_owned());
    }
    Ok(together)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::placement::Placement;
    use glam::DVec3;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Answers what a function of the point's height says.
    struct Heights<F>(F);

    impl<F: Fn(f64) -> Result<f32, String> + Sync> LightVisibility for Heights<F> {
        type Value = f32;
        type Error = String;

        fn visibility(&self, at: DVec3, _: &AreaLight, _: u64) -> Result<f32, String> {
            (self.0)(at.y)
        }
    }

    fn check<F: Fn(f64) -> Result<f32, String> + Sync>(
        make: impl Fn(&Trial) -> F + Sync,
    ) -> Result<(), String> {
        let points: Vec<_> =
            (0..40_u32).map(|n| Placement::receiver(DVec3::Y * f64::from(n), n.into())).collect();
        let light = AreaLight::point(DVec3::Y * 90.0);
        let make = |trial: &Trial| Heights(make(trial));
        let checked = check_light_visibility(make, 40.0, &points, &light, &Agreement::default());
        checked.map_err(|error| error.to_string())
    }

    #[test]
    fn what_depends_on_nothing_passes_and_everything_else_is_named() {
        let height =
            |trial: &Trial, y: f64| (y - trial.placement.shift().y) / trial.placement.scale();
        let good = |trial: &Trial| {
            let trial = *trial;
            move |y| Ok((height(&trial, y) / 40.0) as f32)
        };
        assert_eq!(check(good), Ok(()));
        let refused = |result: Result<(), String>| result.unwrap_err();
        let tiles = |trial: &Trial| {
            let value = if trial.tile_size == 64 { 0.5 } else { 0.5000001 };
            move |_| Ok(value)
        };
        assert!(refused(check(tiles)).contains("tiles of 16"));
        // A length in scene units beside a bare number.
        let offset = |trial: &Trial| {
            let trial = *trial;
            move |y| Ok((height(&trial, y + 1e-4) / 41.0) as f32)
        };
        assert!(refused(check(offset)).contains("scaled by 0.0001"));
        // Matrices of f32.
        let rounded = |trial: &Trial| {
            let trial = *trial;
            move |y| Ok((height(&trial, f64::from(y as f32)) / 40.0).clamp(0.0, 1.0) as f32)
        };
        assert!(refused(check(rounded)).contains("moved by"));
        assert!(refused(check(|_| |_| Ok(1.5))).contains("answer 0 is 1.5"));
        assert!(refused(check(|_| |_| Ok(f32::NAN))).contains("answer 0 is NaN"));
        assert!(refused(check(|_| |_| Err("no map".to_owned()))).contains("no map"));
        let count = AtomicU32::new(0);
        let counting = |_: &Trial| |_| Ok((count.fetch_add(1, Ordering::Relaxed) % 7) as f32 / 7.0);
        assert!(refused(check(counting)).contains("together and apart"));
    }
}
