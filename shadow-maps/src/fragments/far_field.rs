//! What rays meet far from a receiver: a table for what is fine, and what is coherent as
//! it is.

use dsm_core::Transmittance;
use dsm_core::detail::Result;
use dsm_trace::detail::LightFrame;

use super::far_table::FarTable;
use super::fragment::Fragment;
use super::packed::{PackedBuilder, PackedFragments};
use super::range_tree::RangeTree;

/// Nearly all squares of a pixel: what covers as many is coherent.
const FULL: u32 = 60;

/// Fragments of a pixel that lie no farther apart belong together: in sides of a pixel at
/// their depth.
const TOGETHER: f32 = 2.0;

/// The fragments of a map in two parts.
///
/// Sums of optical depth serve what is fine: strands, and leaves smaller than a pixel,
/// where a ray's chance to meet one is what counts. A surface that fills a pixel is met
/// by every ray through it, or by none beside it: such fragments, and those that fill
/// a pixel together without overlap, are traced one by one at any distance.
#[derive(Debug)]
pub(crate) struct FarField {
    pub(crate) table: FarTable,
    pub(crate) coherent: PackedFragments,
    pub(crate) tree: RangeTree,
}

impl FarField {
    /// The parts of `fragments`, which have w in `range`; `None` unless most of them are
    /// fine. O(fragments · log fragments of a pixel).
    pub(crate) fn new<T: Transmittance>(
        fragments: &PackedFragments,
        frame: &LightFrame,
        range: [f32; 2],
    ) -> Result<Option<Self>> {
        let size @ [width, height] = fragments.size();
        let footprint = frame.footprint(1.0) as f32;
        let mut counts = [0_u64; 2];
        fragments.for_each::<T>(|_, _| counts[0] += 1);
        let all = std::mem::take(&mut counts[0]);
        let mut parts = [(); 2].map(|()| PackedBuilder::<T>::new(size, all));
        let [Ok(fine), Ok(coherent)] = &mut parts else {
            return parts.into_iter().collect::<Result<Vec<_>>>().map(|_| None);
        };
        let mut tree = RangeTree::new(size);
        let (mut list, mut flags) = (Vec::new(), Vec::new());
        for pixel in (0..height).flat_map(|y| (0..width).map(move |x| [x, y])) {
            list.clear();
            list.extend(fragments.pixel::<T>(pixel));
            mark(&list, footprint, &mut flags);
            let part = |is_coherent: bool| {
                let some = list.iter().zip(&flags).filter(move |(_, flag)| **flag == is_coherent);
                some.map(|(fragment, _)| *fragment)
            };
            fine.push_pixel(part(false))?;
            coherent.push_pixel(part(true))?;
            counts[0] += part(false).count() as u64;
            counts[1] += part(true).count() as u64;
            part(true).for_each(|fragment| tree.include(pixel, fragment.range()));
        }
        if counts[0] <= counts[1] {
            return Ok(None);
        }
        let [Ok(fine), Ok(coherent)] = parts else { return Ok(None) };
        let table = FarTable::new::<T>(&fine.finish(), range);
        Ok(Some(Self { table, coherent: coherent.finish(), tree }))
    }
}

/// Which of a pixel's fragments, sorted by w, are coherent.
fn mark<T: Transmittance>(list: &[Fragment<T>], footprint: f32, flags: &mut Vec<bool>) {
    flags.clear();
    flags.resize(list.len(), false);
    for last in 0..list.len() {
        // A side of a pixel in depth is as much of w, for w of 1 or not.
        let nearest = list[last].w - TOGETHER * footprint * list[last].w.abs();
        let (mut covered, mut squares) = (0_u64, 0);
        for first in (0..=last).rev().take_while(|&first| list[first].w >= nearest) {
            covered |= list[first].coverage;
            squares += list[first].coverage.count_ones();
            let filled = covered.count_ones();
            // Pieces of a surface do not overlap, as strands before each other do.
            if filled >= FULL && squares - filled <= filled / 8 {
                flags[first..=last].fill(true);
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::frame;
    use super::*;

    #[test]
    fn what_fills_a_pixel_is_coherent() {
        let one = |w: f32, coverage: u64| Fragment {
            w,
            gradient: Some([0.0; 2]),
            opacity: 0.5_f32,
            coverage,
        };
        // A pixel is a 32nd wide at depth 1.
        let footprint = frame([64, 64], 0.0).footprint(1.0) as f32;
        assert!((footprint - 1.0 / 32.0).abs() < 1e-6);
        let mut flags = Vec::new();
        let mut marks = |list: &[Fragment<f32>]| {
            mark(list, footprint, &mut flags);
            flags.clone()
        };
        assert_eq!(marks(&[one(0.2, u64::MAX), one(0.3, u64::MAX >> 8)]), [true, false]);
        // Halves: two that lie together, and one that lies behind.
        let (a, b) = (0xffff_ffff, !0xffff_ffff);
        assert_eq!(marks(&[one(0.2, a), one(0.3, a), one(0.301, b)]), [false, true, true]);
        assert_eq!(marks(&[one(0.3, a), one(0.301, a)]), [false, false], "the same half");
        assert_eq!(marks(&[one(0.3, a), one(0.4, b)]), [false, false]);
        // As strands do: it is filled, by three that overlap.
        let strands = [one(0.3, a), one(0.3005, a << 16), one(0.301, b)];
        assert_eq!(marks(&strands), [false; 3]);
        assert_eq!(marks(&[]), [] as [bool; 0]);
    }
}
