//! Primitives of one kind.

use dsm_core::detail::Result;
use dsm_core::{TileHits, TileSamples, Transmittance};
use fearless_simd::Level;

use super::bins::Bins;
use super::cell_hits::CellHits;
use super::cell_lists::CellLists;
use super::cells::{Cell, CellArea};
use super::dispatched::DispatchedPrimitive;
use super::outline::Rows;
use super::rays::Rays;

/// Primitives of one kind while they are collected.
#[derive(Clone, Debug)]
pub(super) struct LayerBuilder<T, P: DispatchedPrimitive> {
    primitives: Vec<P>,
    outlines: Vec<P::Outline>,
    /// The first primitive of each opacity.
    opacities: Vec<(u32, T)>,
}

/// Primitives of one kind, and where in the map they are.
#[derive(Clone, Debug)]
pub(super) struct Layer<T, P: DispatchedPrimitive> {
    primitives: Vec<P>,
    outlines: Vec<P::Outline>,
    opacities: Vec<(u32, T)>,
    bins: Bins,
}

impl<T: Transmittance, P: DispatchedPrimitive> Default for LayerBuilder<T, P> {
    fn default() -> Self {
        Self { primitives: Vec::new(), outlines: Vec::new(), opacities: Vec::new() }
    }
}

impl<T: Transmittance, P: DispatchedPrimitive> LayerBuilder<T, P> {
    /// Adds those primitives that a ray can meet.
    pub(super) fn extend(
        &mut self,
        rays: &Rays,
        opacity: T,
        primitives: impl IntoIterator<Item = P>,
    ) {
        if opacity == T::splat(0.0) {
            return;
        }
        if self.opacities.last().is_none_or(|&(_, last)| last != opacity) {
            self.opacities.push((self.primitives.len() as u32, opacity));
        }
        for primitive in primitives {
            if let Some(outline) = primitive.outline(rays) {
                self.primitives.push(primitive);
                self.outlines.push(outline);
            }
        }
    }

    pub(super) fn len(&self) -> usize {
        self.primitives.len()
    }

    pub(super) fn build(self, level: Level, rays: &Rays, size: [u32; 2]) -> Layer<T, P> {
        let Self { primitives, outlines, opacities } = self;
        let mut bins = Bins::new(size);
        let order = order(&bins, &outlines, &opacities);
        let primitives: Vec<P> = order.iter().map(|&at| primitives[at as usize]).collect();
        let outlines: Vec<_> = order.iter().map(|&at| outlines[at as usize]).collect();
        P::fill(level, &mut bins, rays, &primitives, &outlines);
        Layer { primitives, outlines, opacities, bins }
    }
}

/// Primitives of each opacity bin by bin, so that a block finds its own side by
/// side in memory.
fn order<T>(bins: &Bins, outlines: &[impl Rows], opacities: &[(u32, T)]) -> Vec<u32> {
    let homes: Vec<u32> = outlines.iter().map(|outline| bins.first(outline) as u32).collect();
    let mut order: Vec<u32> = (0..outlines.len() as u32).collect();
    for (index, &(start, _)) in opacities.iter().enumerate() {
        let end = opacities.get(index + 1).map_or(order.len(), |&(next, _)| next as usize);
        let run = &mut order[start as usize..end];
        if run.len() < bins.count() {
            run.sort_by_key(|&at| homes[at as usize]);
            continue;
        }
        let mut places = vec![0; bins.count() + 1];
        for &home in &homes[start as usize..end] {
            places[home as usize + 1] += 1;
        }
        let mut place = 0;
        for next in &mut places {
            place += *next;
            *next = place;
        }
        for at in start..end as u32 {
            let place = &mut places[homes[at as usize] as usize];
            run[*place as usize] = at;
            *place += 1;
        }
    }
    order
}

impl<T: Transmittance, P: DispatchedPrimitive> Layer<T, P> {
    /// Finds what may cover the cells of `area`.
    pub(super) fn list(&self, level: Level, area: &CellArea, lists: &mut CellLists) {
        P::list(level, lists, &self.bins, &self.outlines, area);
    }

    /// Appends what the rays of `cell` meet to `hits`.
    pub(super) fn meet(
        &self,
        level: Level,
        cell: &Cell,
        mut items: &[u32],
        (rays, samples): (&Rays, &TileSamples),
        cell_hits: &mut CellHits,
        hits: &mut TileHits<T>,
    ) -> Result<()> {
        while let Some(&first) = items.first() {
            // Items ascend, and so do the first primitives of the opacities.
            let next = self.opacities.partition_point(|&(start, _)| start <= first);
            let end = self
                .opacities
                .get(next)
                .map_or(items.len(), |&(start, _)| items.partition_point(|&item| item < start));
            let (run, rest) = items.split_at(end);
            items = rest;
            cell_hits.reset(run.len() * cell.len());
            cell_hits.keeps_items = P::HAS_NORMAL && hits.wants_normals();
            P::meet_all(level, cell, &self.primitives, run, cell_hits);
            let opacity = self.opacities[next - 1].1;
            if cell_hits.keeps_items {
                cell_hits.push_with_normals(opacity, &self.primitives, rays, samples, hits)?;
            } else {
                cell_hits.push(opacity, hits)?;
            }
        }
        Ok(())
    }
}
