//! Hit sources.

use std::fmt::Debug;

use dsm_core::{HitSource, PixelSampling, ShadowCamera, TileHits, TileSamples, Transmittance};
use rayon::prelude::*;

use crate::agreement::Agreement;
use crate::answers::check_answers;
use crate::disagreement::Disagreement;
use crate::trial::Trial;

/// Samples of every pixel that is queried.
const SAMPLES: u32 = 4;

/// Checks a hit source: `make` builds it from the scene of a trial, of this radius
/// before it is placed, for a map of `size` pixels of `camera`, which is placed like it.
/// Extinctions are those of the trial's unit: the scene's over its scale.
///
/// The hits of a sample are the same bits whatever block of pixels and thread it is
/// queried with, and agree wherever the scene stands and however large it is: as many
/// surfaces, at the depths and with the opacities and normals as before, and media of the
/// transmittance as before.
///
/// ```
/// use dsm_core::{Projection, RaySource, SamplePoint, SurfaceHit, View};
/// use dsm_testkit::{Agreement, Trial, check_hit_source};
/// use glam::DVec3;
///
/// // A wall across the view, 2 units from the camera.
/// let view = View { eye: DVec3::Z * 2.0, target: DVec3::ZERO, up: DVec3::Y };
/// let raster = view.raster(Projection::Perspective { fov: 45.0 }, [8, 8])?;
/// let wall = |trial: &Trial| {
///     let depth = (2.0 * trial.placement.scale()) as f32;
///     RaySource(move |_: SamplePoint, hits: &mut dsm_core::RayHits<f32>| {
///         hits.push_surface(SurfaceHit { depth, opacity: 0.5 })
///     })
/// };
/// let camera = raster.shadow_camera();
/// assert_eq!(check_hit_source(wall, 1.0, &camera, [8, 8], &Agreement::default()), Ok(()));
/// # Ok::<(), dsm_core::Error>(())
/// ```
///
/// # Errors
///
/// The first trial whose hits are wrong, and what is wrong with them.
pub fn check_hit_source<T: Transmittance, S: HitSource<T>>(
    make: impl Fn(&Trial) -> S + Sync,
    radius: f64,
    camera: &ShadowCamera,
    size: [u32; 2],
    agreement: &Agreement,
) -> Result<(), Disagreement>
where
    S::Error: Debug,
{
    check_answers(radius, agreement, |trial| answers(&make(trial), trial, radius, camera, size))
}

/// The hits of samples, sample after sample.
fn answers<T: Transmittance, S: HitSource<T>>(
    source: &S,
    trial: &Trial,
    radius: f64,
    camera: &ShadowCamera,
    [width, height]: [u32; 2],
) -> Result<Vec<f64>, String>
where
    S::Error: Debug,
{
    let side = trial.tile_size.max(1);
    let camera = trial.placement.camera(camera);
    let sampling = PixelSampling::new(SAMPLES, 7).map_err(|error| error.to_string())?;
    let corners: Vec<[u32; 2]> = (0..height.div_ceil(side))
        .flat_map(|row| (0..width.div_ceil(side)).map(move |column| [column * side, row * side]))
        .collect();
    let block = |&[x, y]: &[u32; 2]| {
        let size = [side.min(width - x), side.min(height - y)];
        let camera = Some((&camera, [width, height]));
        let samples = TileSamples::new(&sampling, [x as i32, y as i32], size, camera);
        let samples = samples.map_err(|error| error.to_string())?;
        let mut hits = TileHits::with_normals(samples.len());
        let asked = source.hits(&samples, &mut hits);
        asked.map_err(|error| format!("no answer: {error:?}"))?;
        Ok(([x, y], size[0], SampleSums::of(&hits, radius * trial.placement.scale())))
    };
    let blocks: Vec<_> = corners.par_iter().map(block).collect::<Result<_, String>>()?;
    let mut answers = vec![0.0; (width * height * SAMPLES) as usize * SampleSums::COUNT];
    for ([left, top], columns, sums) in blocks {
        let row = (columns * SAMPLES) as usize * SampleSums::COUNT;
        for (y, sums) in (top..).zip(sums.0.chunks(row)) {
            let start = ((y * width + left) * SAMPLES) as usize * SampleSums::COUNT;
            answers[start..start + row].copy_from_slice(sums);
        }
    }
    match answers.iter().find(|sum| !sum.is_finite()) {
        Some(sum) => Err(format!("a sum of hits is {sum}")),
        None => Ok(answers),
    }
}

/// Numbers that change with anything that a sample meets, but not with the order of its
/// hits or the unit of lengths.
struct SampleSums(Vec<f64>);

impl SampleSums {
    /// Of a sample: surfaces, their mean depth, their opacities without and with depth,
    /// three products of normals, the optical depth of media without and with depth.
    const COUNT: usize = 9;

    fn of<T: Transmittance>(hits: &TileHits<T>, unit: f64) -> Self {
        let mut sums = vec![0.0; hits.sample_count() as usize * Self::COUNT];
        // A share that a depth is off by moves this by less.
        let depth = |depth: f32| (f64::from(depth) / unit).ln_1p();
        let worth = |value: T| weighted(value.to_sum().as_ref());
        let mut order: Vec<_> = hits.surfaces().enumerate().collect();
        order.sort_by(|(_, a), (_, b)| {
            let key = |hit: &(u32, dsm_core::SurfaceHit<T>)| (hit.0, hit.1.depth.to_bits());
            key(a).cmp(&key(b)).then(worth(a.1.opacity).total_cmp(&worth(b.1.opacity)))
        });
        let mut normals = vec![None; order.len()];
        for &(surface, normal) in hits.normals() {
            normals[surface as usize] = Some(normal.as_dvec3().normalize_or_zero());
        }
        for (index, (sample, hit)) in order {
            let sums = &mut sums[sample as usize * Self::COUNT..][..Self::COUNT];
            let (depth, opacity) = (depth(hit.depth), worth(hit.opacity));
            sums[0] += 1.0;
            sums[1] += (depth - sums[1]) / sums[0];
            sums[2] += opacity;
            sums[3] += (opacity * depth - sums[3]) / sums[0];
            if let Some(normal) = normals[index] {
                // To either side: its squares and products have none.
                let sides = [normal.x * normal.x, normal.x * normal.y, normal.y * normal.z];
                sums[4..7].iter_mut().zip(sides).for_each(|(sum, side)| *sum += side * opacity);
            }
        }
        for &(sample, segment) in hits.segments() {
            let sums = &mut sums[sample as usize * Self::COUNT..][..Self::COUNT];
            let length = f64::from(segment.far) - f64::from(segment.near);
            let ends = [segment.near_extinction, segment.far_extinction];
            let mean =
                0.5 * ends.map(|extinction| weighted(extinction.as_ref())).iter().sum::<f64>();
            sums[7] += mean * length;
            sums[8] += mean * length * depth(segment.near);
        }
        Self(sums)
    }
}

/// The mean of channels, each with a weight of its own so that none can be exchanged.
fn weighted(channels: &[f64]) -> f64 {
    let weights = || (1_u8..).map(f64::from).take(channels.len());
    weights().zip(channels).map(|(weight, value)| weight * value).sum::<f64>()
        / weights().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dsm_core::{Error, SurfaceHit, VolumeSample};
    use glam::{DMat4, Vec3};

    /// The fault of a source.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Fault {
        None,
        /// A length in scene units beside a bare number.
        Offset,
        /// Depends on the block that is asked for.
        Block,
        Opacity,
        Normal,
        Extinction,
        Fails,
    }

    /// A pane across the view at depth 2, fog behind it.
    struct Pane(Trial, Fault);

    impl HitSource<f32> for Pane {
        type Error = Error;

        fn hits(&self, samples: &TileSamples, hits: &mut TileHits<f32>) -> Result<(), Error> {
            let Self(trial, fault) = *self;
            let scale = trial.placement.scale();
            let elsewhere = trial.placement != crate::Placement::HERE;
            if fault == Fault::Fails {
                return Err(Error::Camera("none"));
            }
            for (index, point) in (0..).zip(samples.points()) {
                let mut depth = 2.0 + point.x / 64.0;
                if fault == Fault::Block && samples.size()[0] < 20 {
                    depth += 1e-6;
                }
                depth *= scale;
                if fault == Fault::Offset {
                    depth += 1e-4;
                }
                let odd = elsewhere && index % 5 == 0;
                let opacity = if odd && fault == Fault::Opacity { 0.6 } else { 0.5 };
                let slant = if odd && fault == Fault::Normal { 0.6 } else { 0.5 };
                let hit = SurfaceHit { depth: depth as f32, opacity };
                hits.push_surface_with_normal(index, hit, Vec3::new(slant, 0.25, 1.0))?;
                let unit = if fault == Fault::Extinction { 1.0 } else { scale };
                let fog = [3.0, 4.0].map(|depth| VolumeSample {
                    depth: (depth * scale) as f32,
                    extinction: (0.25 / unit) as f32,
                });
                hits.push_volume(index, &fog, point.distance_per_depth)?;
            }
            Ok(())
        }
    }

    #[test]
    fn every_fault_is_found() {
        let to_ndc = DMat4::from_cols_array_2d(&[
            [0.5, 0.0, 0.0, 0.0],
            [0.0, -0.5, 0.0, 0.0],
            [-0.5, -0.5, -1.0, -1.0],
            [0.0; 4],
        ]);
        let camera =
            ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) };
        let check = |fault| {
            let make = |trial: &Trial| Pane(*trial, fault);
            let checked = check_hit_source(make, 4.0, &camera, [33, 20], &Agreement::default());
            checked.map_err(|error| error.to_string())
        };
        assert_eq!(check(Fault::None), Ok(()));
        let refused = |fault| check(fault).unwrap_err();
        assert!(refused(Fault::Offset).starts_with("scaled by 0.0001, moved by [0, 0, 0]"));
        assert!(refused(Fault::Block).contains("tiles of 16"));
        for fault in [Fault::Opacity, Fault::Normal] {
            assert!(refused(fault).starts_with("scaled by 1, moved by [2"), "{fault:?}");
        }
        assert!(refused(Fault::Extinction).starts_with("scaled by 0.0001"));
        assert!(refused(Fault::Fails).contains("no answer: Camera"));
    }
}
