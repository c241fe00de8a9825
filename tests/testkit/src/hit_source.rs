//! Hit sources.

use std::fmt::Debug;

use dsm_core::{HitSource, PixelSampling, ShadowCamera, TileHits, TileSamples, Transmittance};
use rayon::prelude::*;

use crate::agreement::Agreement;
use crate::answers::check_answers;
use crate::disagreement::Disagreement;
use crate::trial::Trial;

/// Samples of every pixel that is asked for.
const SAMPLES: u32 = 4;

/// Checks a hit source: `make` makes it of the scene of a trial, which has this radius
/// before it is placed, for a map of `size` pixels of `camera`, which is placed like it.
/// Extinctions are those of the trial's unit: the scene's over its scale.
///
/// The hits of a sample are the same bits whatever block of pixels and thread it is asked
/// with, and agree wherever the scene stands and however large it is: as many surfaces,
/// at depths, of opacities and with normals as before, as much light left by media.
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

/// What samples met, sample after sample.
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
