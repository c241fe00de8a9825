//! Fragments as they are traced: what a pixel holds lies together, and so do
//! neighbours.

use dsm_core::{Error, Result, Transmittance};
use fearless_simd::{Bytes, Simd, SimdBase, f32x16, u32x16};

use crate::FragmentMap;
use crate::range_tree::{Block, LANES};

/// The fragments of a map, block by block of 4 × 4 pixels. A pixel of n
/// fragments is n numbers w, n gradients to the right, n downwards, n opacities
/// a channel, and n lower and n upper halves of masks: one cache line for the
/// two or three of a surface, where columns of all pixels would take six.
#[derive(Clone, Debug)]
pub(crate) struct PackedFragments {
    /// Blocks in a row.
    width: usize,
    /// The first word of each pixel, 16 a block, and the end.
    starts: Vec<u32>,
    words: Vec<u32>,
    /// Words of a fragment.
    each: usize,
}

/// The fragments of one pixel.
#[derive(Clone, Copy)]
pub(crate) struct PixelFragments<'a> {
    /// With words of others behind.
    words: &'a [u32],
    pub(crate) count: usize,
}

/// Planes of up to 16 fragments.
pub(crate) struct Planes<S: Simd> {
    pub(crate) w: f32x16<S>,
    pub(crate) gradient: [f32x16<S>; 2],
    /// Bits of those that there are.
    pub(crate) lanes: u32,
}

impl PackedFragments {
    /// Those of `map`. O(pixels + fragments).
    pub(crate) fn new<T: Transmittance>(map: &FragmentMap<T>) -> Result<Self> {
        let each = 5 + T::CHANNELS;
        let (count, limit) = (map.len() as u64 * each as u64, u64::from(u32::MAX));
        if count > limit {
            return Err(Error::TooLarge { what: "words of fragments", count, limit });
        }
        let blocks = map.size().map(|side| side.div_ceil(4).max(1));
        let mut starts = Vec::with_capacity(blocks[0] as usize * blocks[1] as usize * LANES + 1);
        let mut words = Vec::with_capacity(count as usize + LANES);
        let columns = map.columns();
        for (row, column) in (0..blocks[1]).flat_map(|row| (0..blocks[0]).map(move |x| (row, x))) {
            for lane in 0..LANES as u32 {
                starts.push(words.len() as u32);
                let at = map.pixel_range(4 * column + lane % 4, 4 * row + lane / 4);
                let numbers = [&columns.w, &columns.gradients[0], &columns.gradients[1]];
                for numbers in numbers {
                    words.extend(numbers[at.clone()].iter().map(|number| number.to_bits()));
                }
                for channel in 0..T::CHANNELS {
                    let opacities = columns.opacities[at.clone()].iter();
                    words.extend(opacities.map(|opacity| opacity.channel(channel).to_bits()));
                }
                for half in [0, 32] {
                    let masks = columns.coverage[at.clone()].iter();
                    words.extend(masks.map(|mask| (mask >> half) as u32));
                }
            }
        }
        starts.push(words.len() as u32);
        // The last pixel's vectors reach beyond it.
        words.extend([0; LANES]);
        Ok(Self { width: blocks[0] as usize, starts, words, each })
    }

    /// The fragments of pixel `lane` of a block of the lowest level.
    #[inline(always)]
    pub(crate) fn pixel(&self, block: Block, lane: u32) -> PixelFragments<'_> {
        let block = block.at[1] as usize * self.width + block.at[0] as usize;
        let at = block * LANES + lane as usize;
        let (start, end) = (self.starts[at] as usize, self.starts[at + 1] as usize);
        PixelFragments { words: &self.words[start..], count: (end - start) / self.each }
    }
}

impl PixelFragments<'_> {
    /// The fragments from number `first` on.
    #[inline(always)]
    pub(crate) fn planes<S: Simd>(&self, simd: S, first: usize) -> Planes<S> {
        let count = (self.count - first).min(LANES) as u32;
        Planes {
            w: load(simd, self.words, first),
            gradient: [
                load(simd, self.words, self.count + first),
                load(simd, self.words, 2 * self.count + first),
            ],
            lanes: (1 << count) - 1,
        }
    }

    /// The opacity of a fragment in a channel.
    #[inline(always)]
    pub(crate) fn opacity(&self, fragment: usize, channel: usize) -> f32 {
        f32::from_bits(self.words[(3 + channel) * self.count + fragment])
    }

    /// The mask of a fragment.
    #[inline(always)]
    pub(crate) fn coverage<T: Transmittance>(&self, fragment: usize) -> u64 {
        let low = (3 + T::CHANNELS) * self.count + fragment;
        u64::from(self.words[low + self.count]) << 32 | u64::from(self.words[low])
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, words: &[u32], first: usize) -> f32x16<S> {
    u32x16::from_slice(simd, &words[first..first + LANES]).bitcast()
}
