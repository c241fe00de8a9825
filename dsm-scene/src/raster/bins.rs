//! Primitives binned by the parts of the map that they may cover.

use super::cells::CellArea;
use super::outline::Rows;
use super::primitive::Primitive;
use super::rays::Rays;

/// Pixels along the side of a bin, at least: whole cells of every size.
const SIDE: i32 = 16;

/// Bins have to be larger if there were more of them.
const MAX_BINS: usize = 1 << 20;

/// The largest number of references to primitives in bins: so many for each, and so
/// many in all beside that.
const REFERENCES: (u64, u64) = (15, 1 << 22);

/// Squares of 16 × 16 pixels over the map, and around it one ring of bins that
/// go on without end, for filters that reach beyond the map. Each names the
/// primitives that may touch it, in ascending order. On huge maps and among
/// huge primitives the squares are larger, so that all takes memory for the
/// primitives only.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    /// All bins, the ring too, as cells.
    area: CellArea,
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Bins {
    /// The largest number of primitives: their references in all bins fit in `u32`.
    pub(super) const MAX_PRIMITIVES: usize = 1 << 27;

    /// Bins over a map of `size` pixels, all empty.
    pub(super) fn new(size: [u32; 2]) -> Self {
        let mut bins = Self::of_side(size, SIDE);
        while bins.count() > MAX_BINS {
            bins = Self::of_side(size, bins.area.side * 2);
        }
        bins
    }

    fn of_side(size: [u32; 2], side: i32) -> Self {
        let end = size.map(|size| (i64::from(size) / i64::from(side)) as i32 + 2);
        let area = CellArea { min: [-1; 2], max: end, side };
        Self { area, starts: Vec::new(), items: Vec::new() }
    }

    /// Number of bins.
    pub(super) fn count(&self) -> usize {
        self.area.columns() * self.area.rows()
    }

    /// The bin in which an outline begins.
    pub(super) fn first(&self, outline: &impl Rows) -> usize {
        let Some([low, _]) = outline.bounds() else { return 0 };
        let [x, y] = [0, 1].map(|axis| (self.bin(low[axis], axis) - self.area.min[axis]) as usize);
        y * self.area.columns() + x
    }

    /// The column (`axis` 0) or row (1) of the bin at a raster position.
    fn bin(&self, at: f32, axis: usize) -> i32 {
        ((at / self.area.side as f32).floor() as i32)
            .clamp(self.area.min[axis], self.area.max[axis] - 1)
    }

    /// Sorts primitives into the bins. O(primitives + bins they touch).
    #[inline(always)]
    pub(super) fn fill<P: Primitive>(
        &mut self,
        rays: &Rays,
        primitives: &[P],
        outlines: &[P::Outline],
    ) {
        let bins = self;
        // Twice the same way: count, then place. `starts[bin + 1]` is where the
        // next item of the bin goes, and in the end where the bin ends.
        while !bins.count_touched(rays, primitives, outlines) {
            // Touched by a few at most of the ring's bins and one.
            let size = bins.area.max.map(|end| (end - 2).unsigned_abs() * bins.area.side as u32);
            *bins = Self::of_side(size, bins.area.side * 2);
        }
        let mut start = 0;
        for next in &mut bins.starts {
            start += *next;
            *next = start;
        }
        bins.items = vec![0; start as usize];
        for (item, (primitive, outline)) in (0..).zip(primitives.iter().zip(outlines)) {
            bins.for_touched(rays, primitive, outline, |bin, starts, items| {
                items[starts[bin + 1] as usize] = item;
                starts[bin + 1] += 1;
            });
        }
        bins.starts.pop();
    }

    /// Counts in `starts[bin + 2]` what may touch a bin; false if it is too
    /// much.
    #[inline(always)]
    fn count_touched<P: Primitive>(
        &mut self,
        rays: &Rays,
        primitives: &[P],
        outlines: &[P::Outline],
    ) -> bool {
        self.starts.clear();
        self.starts.resize(self.count() + 2, 0);
        let most = REFERENCES.0 * primitives.len() as u64 + REFERENCES.1;
        let mut references = 0_u64;
        for (primitive, outline) in primitives.iter().zip(outlines) {
            self.for_touched(rays, primitive, outline, |bin, starts, _| {
                starts[bin + 2] += 1;
                references += 1;
            });
            if references > most {
                return false;
            }
        }
        true
    }

    /// Calls `sink` for every bin that a primitive may touch.
    #[inline(always)]
    fn for_touched<P: Primitive>(
        &mut self,
        rays: &Rays,
        primitive: &P,
        outline: &P::Outline,
        mut sink: impl FnMut(usize, &mut [u32], &mut [u32]),
    ) {
        let touched = outline
            .bounds()
            .map(|bounds| [0, 1].map(|axis| bounds.map(|corner| self.bin(corner[axis], axis))));
        let Self { area, starts, items } = self;
        let columns = area.columns();
        let mut visit = |row: i32, first: i32, end: i32| {
            let row = (row - area.min[1]) as usize * columns;
            for column in first..end {
                sink(row + (column - area.min[0]) as usize, starts, items);
            }
        };
        let Some([columns, rows]) = touched else {
            let [columns, rows] = [0, 1].map(|axis| near(rays, primitive, area, axis));
            return rows.for_each(|row| visit(row, columns.start, columns.end));
        };
        let inside = |[first, last]: [i32; 2], axis: usize| {
            first > area.min[axis] && last < area.max[axis] - 1
        };
        if inside(columns, 0) && inside(rows, 1) {
            return outline.for_rows(area, visit);
        }
        (rows[0]..=rows[1]).for_each(|row| visit(row, columns[0], columns[1] + 1));
    }

    /// Every bin that shares cells with `area`: the shared cells, and what may
    /// touch the bin.
    #[inline(always)]
    pub(super) fn parts(&self, area: &CellArea) -> impl Iterator<Item = (CellArea, &[u32])> {
        let per_bin = self.area.side / area.side;
        let area = *area;
        let bins = move |axis: usize| {
            let bin = |cell: i32| {
                cell.div_euclid(per_bin).clamp(self.area.min[axis], self.area.max[axis] - 1)
            };
            let empty = area.columns() == 0 || area.rows() == 0;
            let end = if empty { i32::MIN } else { bin(area.max[axis] - 1) + 1 };
            bin(area.min[axis])..end
        };
        bins(1).flat_map(move |row| bins(0).map(move |column| [column, row])).map(move |place| {
            let mut part = area;
            for (axis, bin) in place.into_iter().enumerate() {
                if bin > self.area.min[axis] {
                    part.min[axis] = part.min[axis].max(bin * per_bin);
                }
                if bin < self.area.max[axis] - 1 {
                    part.max[axis] = part.max[axis].min((bin + 1) * per_bin);
                }
            }
            let [column, row] = [0, 1].map(|axis| (place[axis] - self.area.min[axis]) as usize);
            let bin = row * self.area.columns() + column;
            (part, &self.items[self.starts[bin] as usize..self.starts[bin + 1] as usize])
        })
    }
}

/// The columns (`axis` 0) or rows (1) of bins that a primitive can touch whose
/// outline isn't known: all but those whose planes leave it outside.
fn near<P: Primitive>(
    rays: &Rays,
    primitive: &P,
    area: &CellArea,
    axis: usize,
) -> std::ops::Range<i32> {
    let reaches = |at: i32, upper: bool| {
        let (side, slope) = rays.side(axis, f64::from(at) * f64::from(area.side));
        let mut reaches = false;
        for corner in primitive.corners() {
            let point = corner.point(rays);
            let side = if upper { side(point) } else { -side(point) };
            let rounding = 1e-6 * point.length();
            // Written so that NaN is kept.
            let beyond = side < -slope * (f64::from(corner.radius) * (1.0 + 1e-6) + rounding);
            reaches |= !beyond;
        }
        reaches
    };
    let (mut first, mut end) = (area.min[axis], area.max[axis]);
    while first < end - 1 && !reaches(first + 1, false) {
        first += 1;
    }
    while first < end - 1 && !reaches(end - 1, true) {
        end -= 1;
    }
    first..end
}
