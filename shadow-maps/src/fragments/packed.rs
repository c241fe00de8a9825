//! Fragments as they are traced: what a pixel holds lies together, and so do
//! neighbours.

use dsm_core::detail::Result;
use dsm_core::{Error, Transmittance};
use fearless_simd::{Bytes, Simd, SimdBase, SimdInt, SimdMask, f32x16, u32x16};

use super::columns::FragmentColumns;
use super::fragment::Fragment;
use super::lane_count::LANES;
use super::large_pages::LargePages;
use super::map::FragmentMap;

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
    /// Of the map, in pixels.
    size: [u32; 2],
    /// The first word of each block, and the end.
    starts: LargePages<u32>,
    words: LargePages<u32>,
}

/// The fragments of one block, one by one.
#[derive(Clone, Copy, Default)]
struct BlockList<'a> {
    words: &'a [u32],
    count: usize,
}

impl BlockList<'_> {
    /// A word of a fragment.
    fn word<T: Transmittance>(&self, at: usize, column: usize) -> u32 {
        let first = at / LANES * LANES;
        let many = (self.count - first).min(LANES);
        self.words[bounds(self.count) + first * each::<T>() + column * many + (at - first)]
    }

    /// Which of the block's pixels a fragment is in.
    fn lane<T: Transmittance>(&self, at: usize) -> u32 {
        self.word::<T>(at, 3) & 15
    }

    fn fragment<T: Transmittance>(&self, at: usize) -> Fragment<T> {
        let word = |column| self.word::<T>(at, column);
        let real = |column| f32::from_bits(word(column));
        let coverage = 4 + T::CHANNELS;
        Fragment {
            w: real(0),
            gradient: (word(3) & FACING == 0).then(|| [real(1), real(2)]),
            opacity: T::from_channels(|channel| real(4 + channel)),
            coverage: u64::from(word(coverage + 1)) << 32 | u64::from(word(coverage)),
        }
    }
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

/// Packs the fragments of a map, a row of blocks at a time.
pub(crate) struct PackedBuilder<T> {
    size: [u32; 2],
    /// Those of pixel rows of a row of blocks that is not whole yet.
    rows: FragmentColumns<T>,
    packed: PackedFragments,
    /// Blocks and words so far.
    at: [usize; 2],
    list: Vec<(u32, u32)>,
}

impl<T: Transmittance> PackedBuilder<T> {
    /// A builder for a map of `size` pixels with at most `most` fragments.
    pub(crate) fn new(size: [u32; 2], most: u64) -> Result<Self> {
        let blocks = size.map(|side| side.div_ceil(4).max(1) as usize);
        // 16 of them need 2 bounds at most, and so may what is left of a block.
        let bounds = most.div_ceil(LANES as u64 / 4);
        let count = most.saturating_mul(each::<T>() as u64).saturating_add(bounds);
        let limit = u64::from(u32::MAX);
        let too_large = Error::TooLarge { what: "words of fragments", count, limit };
        if count > limit {
            return Err(too_large);
        }
        // The last chunk's vectors reach beyond it.
        let words = LargePages::try_zeroed(count as usize + LANES).ok_or(too_large)?;
        let packed = PackedFragments {
            width: blocks[0],
            size,
            starts: LargePages::zeroed(blocks[0] * blocks[1] + 1),
            words,
        };
        Ok(Self { size, rows: FragmentColumns::new(), packed, at: [0; 2], list: Vec::new() })
    }

    /// Takes the next pixel of the map, row by row.
    pub(crate) fn push_pixel(&mut self, pixel: impl Iterator<Item = Fragment<T>>) -> Result<()> {
        self.rows.push_pixel(pixel)?;
        let pixels = self.rows.offsets.len() - 1;
        if pixels == 4 * self.size[0] as usize {
            self.end_row();
        }
        Ok(())
    }

    /// Packs the rows that came.
    fn end_row(&mut self) {
        let mut rows = std::mem::take(&mut self.rows);
        self.pack(&rows, 0);
        // Keeps its memory.
        let FragmentColumns { offsets, w, gradients, facing, opacities, coverage } = &mut rows;
        offsets.truncate(1);
        [w].into_iter().chain(gradients).for_each(Vec::clear);
        facing.clear();
        opacities.clear();
        coverage.clear();
        self.rows = rows;
    }

    /// Packs a row of blocks, whose up to 4 rows of pixels are those from `first` on
    /// in `columns`.
    fn pack(&mut self, columns: &FragmentColumns<T>, first: usize) {
        let width = self.size[0] as usize;
        let rows = ((columns.offsets.len() - 1 - first) / width.max(1)).min(4);
        let [block, mut at] = self.at;
        let PackedFragments { starts, words, .. } = &mut self.packed;
        for (start, left) in starts[block..].iter_mut().zip((0..width.max(1)).step_by(4)) {
            // Before the first fragment it is, and takes no memory.
            if at > 0 {
                *start = at as u32;
            }
            self.list.clear();
            for (lane, y, x) in (0..16).map(|lane| (lane, lane / 4, left + lane % 4)) {
                if y < rows && x < width {
                    let pixel = first + y * width + x;
                    let list = columns.offsets[pixel]..columns.offsets[pixel + 1];
                    self.list.extend(list.map(|fragment| (fragment, lane as u32)));
                }
            }
            // Those of a pixel stay in their order.
            self.list.sort_by(|a, b| columns.w[a.0 as usize].total_cmp(&columns.w[b.0 as usize]));
            let mut push = |word: u32| {
                words[at] = word;
                at += 1;
            };
            if self.list.len() > LANES {
                for sign in [-1.0, 1.0] {
                    let chunks = self.list.chunks(LANES);
                    chunks.for_each(|some| push(reach(columns, some, sign).to_bits()));
                }
            }
            for some in self.list.chunks(LANES) {
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
        self.at = [block + self.packed.width, at];
    }

    /// All of them, once every pixel has come.
    pub(crate) fn finish(mut self) -> PackedFragments {
        if self.rows.offsets.len() > 1 {
            self.end_row();
        }
        let end = self.at[1] as u32;
        let last = self.at[0].min(self.packed.starts.len());
        if end > 0 {
            self.packed.starts[last..].fill(end);
        }
        self.packed
    }
}

impl PackedFragments {
    /// Those of `map`. O(pixels + fragments · log fragments of a block).
    pub(crate) fn new<T: Transmittance>(map: &FragmentMap<T>) -> Result<Self> {
        let [width, height] = map.size();
        let mut builder = PackedBuilder::new(map.size(), map.len() as u64)?;
        for row in (0..height).step_by(4) {
            builder.pack(map.columns(), row as usize * width as usize);
        }
        Ok(builder.finish())
    }

    /// Width and height of the map in pixels.
    pub(crate) const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Hands over every fragment with its pixel, block by block; those of a pixel in
    /// their order. O(fragments).
    pub(crate) fn for_each<T: Transmittance>(&self, mut take: impl FnMut([u32; 2], Fragment<T>)) {
        for block in 0..self.starts.len() - 1 {
            let corner = [block % self.width, block / self.width].map(|at| 4 * at as u32);
            let list = self.list::<T>(block);
            for at in 0..list.count {
                let lane = list.lane::<T>(at);
                take([corner[0] + lane % 4, corner[1] + lane / 4], list.fragment(at));
            }
        }
    }

    /// The fragments of a pixel, in their order; none outside the map. O(fragments of
    /// its block).
    pub(crate) fn pixel<T: Transmittance>(
        &self,
        [x, y]: [u32; 2],
    ) -> impl Iterator<Item = Fragment<T>> {
        let is_inside = x < self.size[0] && y < self.size[1];
        let block = (y / 4) as usize * self.width + (x / 4) as usize;
        let list = if is_inside { self.list::<T>(block) } else { BlockList::default() };
        let own = y % 4 * 4 + x % 4;
        (0..list.count)
            .filter(move |&at| list.lane::<T>(at) == own)
            .map(move |at| list.fragment(at))
    }

    fn list<T: Transmittance>(&self, block: usize) -> BlockList<'_> {
        let (start, end) = (self.starts[block] as usize, self.starts[block + 1] as usize);
        BlockList { words: &self.words[start..end], count: count::<T>(end - start) }
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
    use super::super::oracle::{frame, map, pixels};
    use super::*;
    use dsm_core::Rgb;
    use dsm_testkit::config;
    use proptest::prelude::*;

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

    proptest! {
        #![proptest_config(config(33))]

        #[test]
        fn packed_fragments_are_those_of_the_map((size, pixels) in pixels()) {
            let map = map(frame(size, 0.0), &pixels);
            let packed = PackedFragments::new(&map).unwrap();
            // As many as it may be, or many more.
            let mut builder = PackedBuilder::new(size, 2 * map.len() as u64).unwrap();
            let places = || (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
            for [x, y] in places() {
                builder.push_pixel(map.pixel(x, y)).unwrap();
                prop_assert!(packed.pixel([x, y]).eq(map.pixel(x, y)));
            }
            let streamed = builder.finish();
            let end = packed.starts[packed.starts.len() - 1] as usize;
            prop_assert_eq!(&streamed.starts[..], &packed.starts[..]);
            prop_assert_eq!(&streamed.words[..end], &packed.words[..end]);
            let mut all: Vec<([u32; 2], Fragment<f32>)> = Vec::new();
            packed.for_each(|pixel, fragment| all.push((pixel, fragment)));
            // Pixel by pixel, as the map has them.
            all.sort_by_key(|([x, y], _)| [*y, *x]);
            let expected = places().flat_map(|[x, y]| map.pixel(x, y).map(move |one| ([x, y], one)));
            prop_assert!(all.into_iter().eq(expected));
            prop_assert_eq!(packed.pixel::<f32>([size[0], 0]).count(), 0);
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
