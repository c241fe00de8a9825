//! Fragments as they are traced: what a pixel holds lies together, and so do
//! neighbours.

use std::ops::Range;

use dsm_core::{Error, Result, Transmittance};
use fearless_simd::{Bytes, Simd, SimdBase, SimdInt, SimdMask, f32x16, u32x16};

use super::columns::FragmentColumns;
use super::large_pages::LargePages;
use super::map::FragmentMap;
use super::range_tree::LANES;

/// The fragments of a map, block by block of 4 × 4 pixels, the farthest of each
/// block first. A block of many is cut into chunks of 16, whose columns lie
/// together: w, gradients to the right and downwards, pixels with a bit for what
/// faces the camera, opacities a channel, lower and upper halves of masks. Before
/// them, where there is more than one, stand the least w that each chunk reaches,
/// and the greatest.
#[derive(Debug)]
pub(crate) struct PackedFragments {
    /// Blocks in a row.
    width: usize,
    /// The first word of each block, and the end.
    starts: LargePages<u32>,
    words: LargePages<u32>,
}

/// The fragments of one block.
#[derive(Clone, Copy)]
pub(crate) struct BlockFragments<'a> {
    /// With what follows behind.
    words: &'a [u32],
    count: usize,
}

/// Up to 16 fragments of a block.
#[derive(Clone, Copy)]
pub(crate) struct Chunk<'a> {
    /// With what follows behind.
    words: &'a [u32],
    count: usize,
}

/// Planes of up to 16 fragments.
pub(crate) struct Planes<S: Simd> {
    pub(crate) w: f32x16<S>,
    pub(crate) gradient: [f32x16<S>; 2],
    /// Columns and rows of their pixels within the block.
    pub(crate) at: [f32x16<S>; 2],
    /// Bits of those that there are.
    pub(crate) lanes: u32,
}

/// The bit of those that face the camera beside their pixels, 0 to 15.
const FACING: u32 = 1 << 4;

/// Words of a fragment.
const fn each<T: Transmittance>() -> usize {
    6 + T::CHANNELS
}

/// Words of the bounds of a block's fragments.
const fn bounds(count: usize) -> usize {
    if count > LANES { 2 * count.div_ceil(LANES) } else { 0 }
}

/// How many fragments fill these words.
const fn count<T: Transmittance>(words: usize) -> usize {
    if words <= LANES * each::<T>() {
        words / each::<T>()
    } else {
        // Exact, although the bounds of the last 16 are whole.
        words * LANES / (LANES * each::<T>() + 2)
    }
}

/// How far fragments reach from the light (`sign` −1) or towards it (1), as w,
/// with room for rounding.
fn reach<T>(columns: &FragmentColumns<T>, some: &[(u32, u32)], sign: f32) -> f32 {
    let reaches = some.iter().map(|&(at, _)| {
        let at = at as usize;
        let along = columns.gradients[0][at].abs() + columns.gradients[1][at].abs();
        columns.w[at] * sign + 0.503 * along + 4e-6 * columns.w[at].abs()
    });
    sign * reaches.fold(f32::NEG_INFINITY, f32::max)
}

impl PackedFragments {
    /// Those of `map`. O(pixels + fragments · log fragments of a block).
    pub(crate) fn new<T: Transmittance>(map: &FragmentMap<T>) -> Result<Self> {
        let blocks = map.size().map(|side| side.div_ceil(4).max(1));
        let all = || (0..blocks[1]).flat_map(|row| (0..blocks[0]).map(move |column| [column, row]));
        let size = |block| {
            let count = pixels(map, block).map(|(list, _)| list.len()).sum();
            bounds(count) + count * each::<T>()
        };
        let total = all().map(size).sum::<usize>();
        let (count, limit) = (total as u64, u64::from(u32::MAX));
        if count > limit {
            return Err(Error::TooLarge { what: "words of fragments", count, limit });
        }
        let mut starts = LargePages::zeroed(blocks[0] as usize * blocks[1] as usize + 1);
        // The last chunk's vectors reach beyond it.
        let mut words = LargePages::<u32>::zeroed(total + LANES);
        let columns = map.columns();
        let mut list = Vec::new();
        let mut at = 0;
        for (start, block) in starts.iter_mut().zip(all()) {
            *start = at as u32;
            list.clear();
            list.extend(
                pixels(map, block)
                    .flat_map(|(list, lane)| list.map(move |fragment| (fragment as u32, lane))),
            );
            // Those of a pixel stay in their order.
            list.sort_by(|a, b| columns.w[a.0 as usize].total_cmp(&columns.w[b.0 as usize]));
            let mut push = |word: u32| {
                words[at] = word;
                at += 1;
            };
            if list.len() > LANES {
                for sign in [-1.0, 1.0] {
                    list.chunks(LANES).for_each(|some| push(reach(columns, some, sign).to_bits()));
                }
            }
            for some in list.chunks(LANES) {
                let fragments = || some.iter().map(|&(fragment, _)| fragment as usize);
                for numbers in [&columns.w, &columns.gradients[0], &columns.gradients[1]] {
                    fragments().for_each(|fragment| push(numbers[fragment].to_bits()));
                }
                some.iter().for_each(|&(fragment, lane)| {
                    let facing = columns.is_facing(fragment as usize);
                    push(if facing { lane | FACING } else { lane });
                });
                for channel in 0..T::CHANNELS {
                    let opacities = fragments().map(|at| columns.opacities[at].channel(channel));
                    opacities.for_each(|opacity| push(opacity.to_bits()));
                }
                for half in [0, 32] {
                    fragments().for_each(|at| push((columns.coverage[at] >> half) as u32));
                }
            }
        }
        let last = starts.len() - 1;
        starts[last] = at as u32;
        Ok(Self { width: blocks[0] as usize, starts, words })
    }

    /// The fragments of a block of the lowest level.
    #[inline(always)]
    pub(crate) fn block<T: Transmittance>(&self, at: [u32; 2]) -> BlockFragments<'_> {
        let block = at[1] as usize * self.width + at[0] as usize;
        let starts = &*self.starts;
        let (start, end) = (starts[block] as usize, starts[block + 1] as usize);
        BlockFragments { words: &self.words[start..], count: count::<T>(end - start) }
    }
}

/// The fragments of each pixel of a block, and which of the 16 it is.
fn pixels<T: Transmittance>(
    map: &FragmentMap<T>,
    block: [u32; 2],
) -> impl Iterator<Item = (Range<usize>, u32)> {
    let [x, y] = block.map(|at| 4 * at);
    (0..LANES as u32).map(move |lane| (map.pixel_range(x + lane % 4, y + lane / 4), lane))
}

impl<'a> BlockFragments<'a> {
    /// How many times [`Self::chunks`] has to be asked.
    #[inline(always)]
    pub(crate) fn groups(&self) -> usize {
        self.count.div_ceil(LANES * LANES)
    }

    /// Which chunks may have w in [`low`, `high`]: a bit each, for 16 of them.
    #[inline(always)]
    pub(crate) fn chunks<S: Simd>(&self, simd: S, group: usize, low: f32, high: f32) -> u32 {
        if self.count <= LANES {
            return 1;
        }
        let (all, first) = (self.count.div_ceil(LANES), group * LANES);
        let least = load(simd, self.words, first);
        let most = load(simd, self.words, all + first);
        let splat = |value| f32x16::splat(simd, value);
        let some = least.simd_le(splat(high)) & most.simd_ge(splat(low));
        some.to_bitmask() as u32 & lanes(all - first)
    }

    /// One of them.
    #[inline(always)]
    pub(crate) fn chunk<T: Transmittance>(&self, group: usize, chunk: usize) -> Chunk<'a> {
        let first = (group * LANES + chunk) * LANES;
        let at = bounds(self.count) + first * each::<T>();
        Chunk { words: &self.words[at..], count: (self.count - first).min(LANES) }
    }
}

impl Chunk<'_> {
    #[inline(always)]
    pub(crate) fn planes<S: Simd>(&self, simd: S) -> Planes<S> {
        let column = |column: usize| column * self.count;
        let at: u32x16<S> = load(simd, self.words, column(3)).bitcast();
        Planes {
            w: load(simd, self.words, 0),
            gradient: [load(simd, self.words, column(1)), load(simd, self.words, column(2))],
            at: [(at & 3).to_float(), ((at >> 2) & 3).to_float()],
            lanes: lanes(self.count),
        }
    }

    /// Whether a fragment is taken to face the camera.
    #[inline(always)]
    pub(crate) fn is_facing(&self, fragment: usize) -> bool {
        self.words[3 * self.count + fragment] & FACING != 0
    }

    /// The opacity of a fragment in a channel.
    #[inline(always)]
    pub(crate) fn opacity(&self, fragment: usize, channel: usize) -> f32 {
        f32::from_bits(self.words[(4 + channel) * self.count + fragment])
    }

    /// The mask of a fragment.
    #[inline(always)]
    pub(crate) fn coverage<T: Transmittance>(&self, fragment: usize) -> u64 {
        let low = (4 + T::CHANNELS) * self.count + fragment;
        u64::from(self.words[low + self.count]) << 32 | u64::from(self.words[low])
    }
}

/// The bits of as many as there are, 16 at most.
#[inline(always)]
const fn lanes(count: usize) -> u32 {
    if count < LANES { (1 << count) - 1 } else { u16::MAX as u32 }
}

#[inline(always)]
fn load<S: Simd>(simd: S, words: &[u32], first: usize) -> f32x16<S> {
    u32x16::from_slice(simd, &words[first..first + LANES]).bitcast()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dsm_core::Rgb;

    #[test]
    fn bounds_hold_whole_pixels_and_little_more() {
        let columns = FragmentColumns {
            offsets: vec![0, 3],
            w: vec![0.25, 0.5, 0.75],
            gradients: [vec![0.0, 0.2, -0.1], vec![0.0, -0.4, 0.1]],
            facing: vec![1],
            opacities: vec![1.0_f32; 3],
            coverage: vec![1; 3],
        };
        for (some, [least, most]) in [
            (vec![(0, 0)], [0.25, 0.25]),
            (vec![(1, 0)], [0.2, 0.8]),
            (vec![(0, 0), (1, 0), (2, 0)], [0.2, 0.85]),
        ] {
            let [low, high] = [-1.0, 1.0].map(|sign| reach(&columns, &some, sign));
            assert!(low < least && high > most && low > least - 0.01 && high < most + 0.01);
        }
    }

    #[test]
    fn words_tell_how_many_fragments_they_hold() {
        for fragments in 0..2000 {
            let words = bounds(fragments) + fragments * each::<f32>();
            assert_eq!(count::<f32>(words), fragments);
            let words = bounds(fragments) + fragments * each::<Rgb>();
            assert_eq!(count::<Rgb>(words), fragments);
        }
    }
}
