//! The finest level of a map from hits (Selgrad et al. 2014, §4.1).

use std::ops::ControlFlow;

use dsm_core::detail::Result;
use dsm_core::{
    Error, HitSource, PixelSampling, Progress, ShadowCamera, TileHits, TileSamples, Transmittance,
};
use dsm_trace::detail::LightFrame;
use rayon::prelude::*;

use super::lists::FragmentLists;

/// Texels along the side of what is asked for at once.
const TILE: u32 = 16;

/// Collects the fragments of every texel from what a [`HitSource`] shows through its
/// middle, when the shutter is half way.
///
/// What lies at the light's depth or nearer is left out. Every texel is a function of its
/// own ray: the same on any number of threads.
#[derive(Clone, Debug)]
pub struct ListBuilder {
    camera: ShadowCamera,
    frame: LightFrame,
    layers: u32,
}

/// Hits as they came, not sorted.
#[derive(Clone, Debug)]
pub struct CollectedHits<T> {
    size: [u32; 2],
    /// Where each texel's hits start, and the end.
    starts: Vec<u32>,
    hits: Vec<(f32, T)>,
}

/// What a bound of layers left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ListCounts {
    /// Surfaces that the rays met.
    pub hits: u64,
    /// Texels with more fragments than are kept, the nearest.
    pub cut_pixels: u64,
    /// The most light that one of them lets through too much behind what it keeps.
    pub most_gained: f64,
    /// The same in the mean over all texels.
    pub mean_gained: f64,
}

impl ListBuilder {
    /// The largest bound of layers a texel.
    pub const MAX_LAYERS: u32 = 1 << 20;

    /// For a map of `size` texels that `camera`'s NDC \[0, 1\]² covers, with the light's
    /// centre at `light_depth` on its axis.
    ///
    /// # Errors
    ///
    /// As [`LightFrame::new`].
    pub fn new(camera: ShadowCamera, size: [u32; 2], light_depth: f64) -> Result<Self> {
        let frame = LightFrame::new(&camera, size, light_depth)?;
        Ok(Self { camera, frame, layers: Self::MAX_LAYERS })
    }

    /// Sets the maximum number of fragments a texel: the nearest are kept (§6).
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for none.
    pub fn with_layers(self, layers: u32) -> Result<Self> {
        if layers == 0 {
            return Err(Error::Setting { setting: "layers", reason: "there must be one or more" });
        }
        Ok(Self { layers: layers.min(Self::MAX_LAYERS), ..self })
    }

    /// The camera of the map.
    #[must_use]
    pub const fn camera(&self) -> &ShadowCamera {
        &self.camera
    }

    /// The frame of the map.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// The most fragments of a texel.
    #[must_use]
    pub const fn layers(&self) -> u32 {
        self.layers
    }

    /// The hits of all texels, in parallel. `watch` is told of rows of 16 texels before
    /// each, and may break it off: then there is nothing. O(hits).
    ///
    /// # Errors
    ///
    /// Those of the source; [`Error::Setting`] if it shows media, which a fragment cannot
    /// hold; [`Error::TooLarge`] past 2³² hits.
    pub fn collect<T, S>(
        &self,
        source: &S,
        mut watch: impl FnMut(Progress) -> ControlFlow<()>,
    ) -> std::result::Result<Option<CollectedHits<T>>, S::Error>
    where
        T: Transmittance,
        S: HitSource<T>,
    {
        let [width, height] = self.frame.size();
        let mut all = CollectedHits::new([width, height]);
        let rows = u64::from(height.div_ceil(TILE));
        for (row, top) in (0..).zip((0..height).step_by(TILE as usize)) {
            if watch(Progress::new(row, rows)).is_break() {
                return Ok(None);
            }
            let blocks: std::result::Result<Vec<_>, S::Error> = (0..width.div_ceil(TILE))
                .into_par_iter()
                .map_init(
                    || TileHits::new(0),
                    |hits, column| {
                        let min = [column * TILE, top];
                        let size = [width - min[0], height - min[1]].map(|side| side.min(TILE));
                        self.block(source, min, size, hits)
                    },
                )
                .collect();
            let blocks = blocks?;
            for y in 0..TILE.min(height - top) {
                blocks.iter().try_for_each(|block| all.append_row(block, y))?;
            }
        }
        Ok(Some(all))
    }

    /// The hits of a block of texels.
    fn block<T, S>(
        &self,
        source: &S,
        min: [u32; 2],
        size: [u32; 2],
        hits: &mut TileHits<T>,
    ) -> std::result::Result<CollectedHits<T>, S::Error>
    where
        T: Transmittance,
        S: HitSource<T>,
    {
        let camera = Some((&self.camera, self.frame.size()));
        // Maps have at most 2²⁴ texels a side.
        let corner = min.map(|side| side as i32);
        let samples = TileSamples::new(&PixelSampling::centre(), corner, size, camera)?;
        hits.reset(samples.len());
        source.hits(&samples, hits)?;
        if !hits.segments().is_empty() {
            let reason = "a prefiltered map holds surfaces, no media";
            return Err(Error::Setting { setting: "scene", reason }.into());
        }
        let light_depth = self.frame.light_depth();
        let seen = |depth: f32| depth > 0.0 && f64::from(depth) > light_depth;
        // By counting: texel by texel, in the order of the source.
        let mut starts = vec![0_u32; samples.len() as usize + 1];
        for (sample, hit) in hits.surfaces() {
            starts[sample as usize] += u32::from(seen(hit.depth));
        }
        let mut count = 0;
        for start in &mut starts {
            count += std::mem::replace(start, count);
        }
        let mut next = starts.clone();
        let mut sorted = vec![(0.0, T::BLOCKED); count as usize];
        for (sample, hit) in hits.surfaces().filter(|(_, hit)| seen(hit.depth)) {
            let at = &mut next[sample as usize];
            sorted[*at as usize] = (hit.depth.recip().min(f32::MAX), hit.opacity);
            *at += 1;
        }
        Ok(CollectedHits { size, starts, hits: sorted })
    }

    /// The lists of these hits, the nearest first, of which the nearest are kept, and
    /// what that left out. O(h log h) for the h hits of a texel.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 2³² fragments.
    pub fn sort<T: Transmittance>(
        &self,
        mut collected: CollectedHits<T>,
    ) -> Result<(FragmentLists<T>, ListCounts)> {
        let mut counts = ListCounts { hits: collected.hits.len() as u64, ..Default::default() };
        let mut lists = FragmentLists::new(collected.size);
        let texels = collected.starts.len() - 1;
        for texel in 0..texels {
            let [start, end] = [0, 1].map(|end| collected.starts[texel + end] as usize);
            let hits = &mut collected.hits[start..end];
            // Those at one depth stay in the order of the source.
            hits.sort_by(|a, b| b.0.total_cmp(&a.0));
            let (kept, rest) = hits.split_at(hits.len().min(self.layers as usize));
            kept.iter().for_each(|&(w, opacity)| lists.push(w, opacity));
            lists.finish_texel()?;
            if !rest.is_empty() {
                counts.cut_pixels += 1;
                let gained = gained(kept, rest);
                counts.most_gained = counts.most_gained.max(gained);
                counts.mean_gained += gained / texels as f64;
            }
        }
        Ok((lists, counts))
    }
}

/// How much of the light `rest` stops behind `kept`, in the channel where that is most.
fn gained<T: Transmittance>(kept: &[(f32, T)], rest: &[(f32, T)]) -> f64 {
    let passes = |some: &[(f32, T)], channel: usize| -> f64 {
        some.iter().map(|(_, opacity)| 1.0 - f64::from(opacity.channel(channel))).product()
    };
    let stopped = |channel| passes(kept, channel) * (1.0 - passes(rest, channel));
    (0..T::CHANNELS).map(stopped).fold(0.0, f64::max)
}

impl<T: Transmittance> CollectedHits<T> {
    /// No texels yet, of a map of this size.
    #[must_use]
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, starts: vec![0], hits: Vec::new() }
    }

    /// Appends a texel, row by row: the w and the opacity of each of its hits, in any
    /// order. Those that take nothing away are none.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 2³² hits.
    pub fn push_texel(&mut self, hits: impl IntoIterator<Item = (f32, T)>) -> Result<()> {
        let is_hit = |(w, opacity): &(f32, T)| *w > 0.0 && *opacity != T::splat(0.0);
        self.hits.extend(hits.into_iter().filter(is_hit));
        let (count, limit) = (self.hits.len() as u64, u64::from(u32::MAX));
        let too_large = |_| Error::TooLarge { what: "hits", count, limit };
        self.starts.push(u32::try_from(count).map_err(too_large)?);
        Ok(())
    }

    /// Appends row `y` of a block.
    fn append_row(&mut self, block: &Self, y: u32) -> Result<()> {
        let [width, _] = block.size.map(|side| side as usize);
        let row = y as usize * width;
        let (before, first) = (self.hits.len(), block.starts[row] as usize);
        let last = block.starts[row + width] as usize;
        let (count, limit) = ((before + last - first) as u64, u64::from(u32::MAX));
        if count > limit {
            return Err(Error::TooLarge { what: "hits", count, limit });
        }
        self.hits.extend_from_slice(&block.hits[first..last]);
        // Checked above.
        let ends = block.starts[row + 1..=row + width].iter();
        self.starts.extend(ends.map(|&end| (before + end as usize - first) as u32));
        Ok(())
    }
}
