//! Builds of a pixel's media.

use dsm_core::detail::{OpticalDepthChords, Result, VolumeSegment};
use dsm_core::{TileHits, TileSamples, Tolerance, Transmittance};

use super::columns::MediaColumns;

/// The most slabs of a pixel: where its optical depth would need more, they are coarser.
pub(crate) const MOST_SLABS: usize = 256;

/// Makes slabs of the media that one sample of each pixel passes, and measures how far they
/// are off. Keeps its memory from block to block.
#[derive(Debug)]
pub(crate) struct MediaBuilder<T: Transmittance> {
    chords: OpticalDepthChords<T>,
    /// Where the segments of each sample end, and those, sample by sample.
    ends: Vec<u32>,
    sorted: Vec<VolumeSegment<T>>,
    borders: Vec<(f32, T)>,
}

/// Media of a block of pixels.
#[derive(Debug)]
pub(crate) struct BlockMedia<T> {
    pub(crate) columns: MediaColumns<T>,
    /// A bound of the error of each pixel's transmittance, up to any depth.
    pub(crate) errors: Vec<f32>,
}

impl<T: Transmittance> MediaBuilder<T> {
    /// A builder that keeps optical depths within `tolerance`, or within what single chords
    /// have to be off.
    pub(crate) fn new(tolerance: Tolerance) -> Self {
        Self {
            chords: OpticalDepthChords::new(tolerance.epsilon().into(), MOST_SLABS + 1),
            ends: Vec::new(),
            sorted: Vec::new(),
            borders: Vec::new(),
        }
    }

    /// The media of a block behind `light_depth`, of which each pixel has one of `samples`.
    pub(crate) fn block(
        &mut self,
        samples: &TileSamples,
        hits: &TileHits<T>,
        light_depth: f32,
    ) -> Result<BlockMedia<T>> {
        self.sort(samples.len() as usize, hits);
        let mut columns = MediaColumns::new();
        let mut errors = Vec::new();
        let mut start = 0;
        for (sample, &end) in (0_u32..).zip(&self.ends) {
            self.borders.clear();
            if start < end {
                let segments = &self.sorted[start as usize..end as usize];
                let stretch = samples.point(sample).distance_per_depth;
                let vertices = self.chords.build(segments, light_depth);
                // Of sums of rounded numbers the rounding does not add up.
                let mut so_far = T::splat(0.0).to_sum();
                for vertex in vertices {
                    let thickness = T::from_channels(|channel| {
                        let rise = vertex.value.as_ref()[channel] - so_far.as_ref()[channel];
                        ((rise.max(0.0) / stretch) as f32).min(f32::MAX)
                    });
                    for (channel, sum) in so_far.as_mut().iter_mut().enumerate() {
                        *sum += f64::from(thickness.channel(channel)) * stretch;
                    }
                    self.borders.push((vertex.z, thickness));
                }
                let nothing = T::splat(0.0);
                while self.borders.last().is_some_and(|&(_, last)| last == nothing) {
                    self.borders.pop();
                }
            }
            let is_clear = start == end;
            errors.push(if is_clear {
                0.0
            } else {
                up(self.error(samples.point(sample).distance_per_depth))
            });
            start = end;
            columns.push_pixel(self.borders.iter().copied())?;
        }
        Ok(BlockMedia { columns, errors })
    }

    /// The segments of all samples, sample by sample.
    fn sort(&mut self, samples: usize, hits: &TileHits<T>) {
        let Self { ends, sorted, .. } = self;
        ends.clear();
        ends.resize(samples, 0);
        sorted.clear();
        for (sample, _) in hits.segments() {
            ends[*sample as usize] += 1;
        }
        let mut count = 0;
        for end in &mut *ends {
            // Where the sample's next segment goes; where they end, when all are there.
            count += std::mem::replace(end, count);
        }
        let Some(&(_, first)) = hits.segments().first() else { return };
        sorted.resize(count as usize, first);
        for &(sample, segment) in hits.segments() {
            let at = &mut ends[sample as usize];
            sorted[*at as usize] = segment;
            *at += 1;
        }
    }

    /// A bound of the difference between the transmittance of the slabs and of the media up
    /// to any depth, along the pixel's own ray of this stretch.
    fn error(&self, stretch: f64) -> f64 {
        let (pieces, of_pieces) = self.chords.pieces();
        let mut worst: f64 = 0.0;
        for channel in 0..T::CHANNELS {
            let mut borders = self.borders.iter().peekable();
            let (mut at, mut depth) = (0.0, 0.0);
            let (mut before, mut least) = (0.0_f64, 0.0_f64);
            for piece in pieces {
                let z = f64::from(piece.z);
                // The optical depth of the slabs there.
                while let Some(&(border, thickness)) =
                    borders.next_if(|(border, _)| f64::from(*border) <= z)
                {
                    depth += f64::from(thickness.channel(channel)) * stretch;
                    at = f64::from(border);
                }
                let within = borders.peek().map_or(0.0, |&&(border, thickness)| {
                    let share = (z - at) / (f64::from(border) - at);
                    f64::from(thickness.channel(channel)) * stretch * share
                });
                let (have, want) = (depth + within, piece.value.as_ref()[channel]);
                let off = (have - want).abs();
                worst = worst.max((before.max(off) + of_pieces) * (-least).exp());
                (before, least) = (off, have.min(want));
            }
        }
        worst.min(1.0)
    }
}

/// The least `f32` that is not below `error`.
fn up(error: f64) -> f32 {
    let nearest = error as f32;
    if f64::from(nearest) < error { nearest.next_up() } else { nearest }
}
