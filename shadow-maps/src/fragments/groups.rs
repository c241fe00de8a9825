//! The hits of a pixel, put together to fragments.

use dsm_core::Transmittance;

use super::fold::fold;
use super::fragment::Fragment;

/// How far two hits of a pixel may lie from each other's planes and still be one
/// fragment: in sides of a pixel at their depth. More, and lit surfaces shade
/// themselves.
pub(crate) const SAME_PLANE: f64 = 0.01;

/// The same for hits without a normal, whose depth within the pixel is unknown.
const SAME_DEPTH: f64 = 0.2;

/// One hit of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelHit<T> {
    /// At the place of the sample.
    pub(crate) w: f64,
    pub(crate) sample: u8,
    /// None: it faces the camera.
    pub(crate) gradient: Option<[f64; 2]>,
    pub(crate) opacity: T,
}

/// Hits of a pixel in one plane.
#[derive(Clone, Copy, Debug)]
struct Group<T> {
    first: PixelHit<T>,
    coverage: u64,
}

/// What the samples of a pixel stand for.
#[derive(Clone, Debug)]
pub(crate) struct SampleGrid {
    /// Where each is in its pixel.
    places: Vec<[f64; 2]>,
    /// The squares of the mask that it stands for.
    squares: Vec<u64>,
    /// The side of a pixel at depth 1.
    footprint: f64,
}

impl SampleGrid {
    /// `side` × `side` samples, 1, 2, 4 or 8.
    pub(crate) fn new(side: u32, footprint: f64) -> Self {
        let place = |sample: u32| {
            [sample % side, sample / side].map(|at| (f64::from(at) + 0.5) / f64::from(side))
        };
        let squares = |sample: u32| {
            let squares = 8 / side;
            let (column, row) = (sample % side * squares, sample / side * squares);
            let line = ((1_u64 << squares) - 1) << column;
            (row..row + squares).fold(0, |bits, row| bits | line << (8 * row))
        };
        let samples = 0..side * side;
        Self {
            places: samples.clone().map(place).collect(),
            squares: samples.map(squares).collect(),
            footprint,
        }
    }
}

/// Makes fragments of one pixel after the other, and keeps its memory in between.
#[derive(Debug)]
pub(crate) struct Grouping<T> {
    groups: Vec<Group<T>>,
    pixel: Vec<Fragment<T>>,
}

impl<T> Default for Grouping<T> {
    fn default() -> Self {
        Self { groups: Vec::new(), pixel: Vec::new() }
    }
}

impl<T: Transmittance> Grouping<T> {
    /// Appends the fragments of a pixel's hits, the farthest first; whether there were
    /// more than `most`, of which the last then holds the rest, and the light that this
    /// gains ([`fold`]). Hits come with growing w. O(h) for h hits
    /// where few fragments overlap in depth, else O(h) for each of those.
    pub(crate) fn append(
        &mut self,
        grid: &SampleGrid,
        hits: impl Iterator<Item = PixelHit<T>>,
        most: u32,
        fragments: &mut Vec<Fragment<T>>,
    ) -> (bool, f64) {
        let Self { groups, pixel } = self;
        groups.clear();
        for hit in hits {
            let squares = grid.squares[usize::from(hit.sample)];
            match find(groups, &hit, squares, grid) {
                Some(group) => group.coverage |= squares,
                None => groups.push(Group { first: hit, coverage: squares }),
            }
        }
        pixel.clear();
        pixel.extend(groups.iter().map(|group| fragment(group, grid)));
        pixel.sort_by(|a, b| {
            let key = |one: &Fragment<T>| (one.coverage, one.opacity.channel(0).to_bits());
            a.w.total_cmp(&b.w).then_with(|| key(a).cmp(&key(b)))
        });
        let is_cut = pixel.len() > most as usize;
        let gained = fold(pixel, most as usize);
        fragments.append(pixel);
        (is_cut, gained)
    }
}

/// The last group that `hit` can join.
fn find<'a, T: Transmittance>(
    groups: &'a mut [Group<T>],
    hit: &PixelHit<T>,
    squares: u64,
    grid: &SampleGrid,
) -> Option<&'a mut Group<T>> {
    // No group begins nearer than the hit.
    let near = |sides: f64| sides * grid.footprint * hit.w;
    let Some(gradient) = hit.gradient else {
        let near = near(SAME_DEPTH);
        return groups.iter_mut().rev().take_while(|group| hit.w - group.first.w <= near).find(
            |group| {
                group.coverage & squares == 0
                    && group.first.gradient.is_none()
                    && group.first.opacity == hit.opacity
            },
        );
    };
    let near = near(SAME_PLANE);
    // Within a pixel, the plane of the hit gets no farther.
    let reach = near + gradient[0].abs() + gradient[1].abs();
    let to = grid.places[usize::from(hit.sample)];
    groups.iter_mut().rev().take_while(|group| hit.w - group.first.w <= reach).find(|group| {
        let Some(of_first) = group.first.gradient else { return false };
        let from = grid.places[usize::from(group.first.sample)];
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let apart = |of: [f64; 2]| (hit.w - group.first.w - (of[0] * dx + of[1] * dy)).abs();
        group.coverage & squares == 0
            && group.first.opacity == hit.opacity
            && apart(of_first).max(apart(gradient)) <= near
    })
}

fn fragment<T: Transmittance>(group: &Group<T>, grid: &SampleGrid) -> Fragment<T> {
    let PixelHit { w, sample, gradient, opacity } = group.first;
    let coverage = group.coverage;
    let finite = |along: &[f64; 2]| along.iter().all(|along| (*along as f32).is_finite());
    match gradient.filter(finite) {
        Some(along) => {
            let [x, y] = grid.places[usize::from(sample)];
            let w = w + along[0] * (0.5 - x) + along[1] * (0.5 - y);
            let gradient = Some(along.map(|along| along as f32 + 0.0));
            Fragment { w: w as f32, gradient, opacity, coverage }
        }
        None => Fragment { w: w as f32, gradient: None, opacity, coverage },
    }
}
