//! A pixel's rays, and what gets past them by the definition, in `f64`.

use dsm_core::{Error, HitSource, SurfaceHit, TileHits, TileSamples, Transmittance, VolumeSample};
use proptest::prelude::*;

/// Something opaque to a degree in a ray's way: depth and opacity.
pub(crate) type Sheet = (f32, f32);

/// A medium of constant extinction: near, length, extinction.
pub(crate) type Slab = (f32, f32, f32);

/// What one ray meets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ray {
    pub(crate) sheets: Vec<Sheet>,
    pub(crate) slabs: Vec<Slab>,
}

impl Ray {
    /// The fraction of light left of what starts at `start`, behind everything
    /// at depth ≤ `z`, or < `z` if that is not `inclusive`. In channel 1 sheets
    /// are half as opaque.
    fn left(&self, channel: usize, start: f32, z: f32, inclusive: bool) -> f64 {
        let within = |depth: f32| depth > start && (depth < z || (inclusive && depth == z));
        let passed = self.sheets.iter().filter(|(depth, _)| within(*depth));
        let surfaces: f64 =
            passed.map(|&(_, opacity)| 1.0 - f64::from(shade(channel, opacity))).product();
        let optical_depth: f64 = self
            .slabs
            .iter()
            .map(|&(near, length, extinction)| {
                let [low, high] = [near.max(start), (near + length).min(z)].map(f64::from);
                f64::from(extinction) * (high - low).max(0.0)
            })
            .sum();
        surfaces * (-optical_depth).exp()
    }

    /// The depths behind `start` where the ray's light falls.
    fn falls(&self, channels: usize, start: f32) -> Vec<f32> {
        let mut depths: Vec<f32> = self.sheets.iter().map(|sheet| sheet.0).collect();
        depths.retain(|&depth| depth > start);
        depths.sort_by(f32::total_cmp);
        depths.dedup();
        depths.retain(|&depth| {
            (0..channels).any(|channel| {
                self.left(channel, start, depth, true) < self.left(channel, start, depth, false)
            })
        });
        depths
    }
}

fn shade(channel: usize, opacity: f32) -> f32 {
    if channel == 1 && opacity < 1.0 { opacity / 2.0 } else { opacity }
}

/// The rays of the only pixel of a map, all of one weight.
#[derive(Clone, Debug)]
pub(crate) struct Pixel(pub(crate) Vec<Ray>);

impl Pixel {
    /// V behind `start`: at `z`, or just before it.
    pub(crate) fn visibility(&self, channel: usize, start: f32, z: f32, inclusive: bool) -> f64 {
        let left = self.0.iter().map(|ray| ray.left(channel, start, z, inclusive));
        left.sum::<f64>() / self.0.len() as f64
    }

    /// The depths behind `start` where the light of any ray falls, each as
    /// often as that of a ray does.
    pub(crate) fn falls(&self, channels: usize, start: f32) -> Vec<f32> {
        let mut falls: Vec<f32> =
            self.0.iter().flat_map(|ray| ray.falls(channels, start)).collect();
        falls.sort_by(f32::total_cmp);
        falls
    }

    /// Everything that happens, and what lies between.
    pub(crate) fn depths(&self) -> Vec<f32> {
        let ends = |ray: &Ray| -> Vec<f32> {
            let sheets = ray.sheets.iter().map(|sheet| sheet.0);
            let slabs = ray.slabs.iter().flat_map(|&(near, length, _)| [near, near + length]);
            sheets.chain(slabs).collect()
        };
        let mut depths: Vec<f32> = self.0.iter().flat_map(ends).collect();
        depths.push(50.0);
        depths.sort_by(f32::total_cmp);
        depths.dedup();
        let between: Vec<f32> = depths
            .windows(2)
            .flat_map(|pair| [0.3, 0.7].map(|at| pair[0] + at * (pair[1] - pair[0])))
            .collect();
        depths.extend(between);
        depths
    }
}

impl<T: Transmittance> HitSource<T> for Pixel {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), Error> {
        assert_eq!(samples.len() as usize, self.0.len());
        for (sample, ray) in (0..).zip(&self.0) {
            for &(depth, opacity) in &ray.sheets {
                let opacity = T::from_channels(|channel| shade(channel, opacity));
                hits.push_surface(sample, SurfaceHit { depth, opacity })?;
            }
            for &(near, length, extinction) in &ray.slabs {
                let ends = [near, near + length];
                let ends =
                    ends.map(|depth| VolumeSample { depth, extinction: T::splat(extinction) });
                hits.push_volume(sample, &ends, 1.0)?;
            }
        }
        Ok(())
    }
}

/// Depths from few values, so that sheets meet.
fn sheet() -> impl Strategy<Value = Sheet> {
    let opacity = prop_oneof![
        3 => Just(1.0_f32), 3 => Just(0.5), 2 => 0.01_f32..0.99, 1 => Just(1e-3_f32),
        1 => Just(1.0 - 1e-3)
    ];
    let depth = prop_oneof![2 => (2_u8..20).prop_map(|z| f32::from(z) / 2.0), 1 => 1.0_f32..10.0];
    (depth, opacity)
}

/// `count` rays of some sheets each.
pub(crate) fn sheets(count: usize) -> impl Strategy<Value = Pixel> {
    let ray = proptest::collection::vec(sheet(), 0..9)
        .prop_map(|sheets| Ray { sheets, slabs: Vec::new() });
    proptest::collection::vec(ray, count).prop_map(Pixel)
}

/// `count` rays of sheets and media.
pub(crate) fn media(count: usize) -> impl Strategy<Value = Pixel> {
    let slab = ((2_u8..16).prop_map(|z| f32::from(z) / 2.0), 0.25_f32..4.0, 0.05_f32..3.0);
    let ray = (proptest::collection::vec(sheet(), 0..3), proptest::collection::vec(slab, 0..3))
        .prop_map(|(sheets, slabs)| Ray { sheets, slabs });
    proptest::collection::vec(ray, count).prop_map(Pixel)
}
