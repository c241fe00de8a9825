//! The cells of a light, each with a sample.

use dsm_core::AreaLight;
use dsm_core::detail::random::{golden, next_bits, unit};
use glam::DVec3;

/// Sub-cells along a side of a cell, of which each keeps one blocker (§5.2.2).
pub(crate) const PARTS: u32 = 3;

/// A grid of cells over the light's square, each with a jittered sample, row after
/// row: those of one receiver.
#[derive(Debug)]
pub(crate) struct LightCells {
    side: u32,
    places: Vec<[f64; 2]>,
    targets: Vec<(DVec3, f64)>,
}

impl LightCells {
    pub(crate) const fn new(side: u32) -> Self {
        Self { side, places: Vec::new(), targets: Vec::new() }
    }

    /// Takes the samples of a receiver, by its seed.
    pub(crate) fn sample(&mut self, receiver: DVec3, light: &AreaLight, seed: u64) {
        let (side, mut state) = (f64::from(self.side), seed);
        let first = golden(0.0, seed as f64);
        self.places.clear();
        self.targets.clear();
        for row in 0..self.side {
            for column in 0..self.side {
                let mut place = [column, row].map(f64::from);
                place.iter_mut().for_each(|at| *at = (*at + unit(next_bits(&mut state))) / side);
                let time = golden(first, self.targets.len() as f64);
                self.places.push(place);
                self.targets.push((light.at(receiver, place[0], place[1]), time));
            }
        }
    }

    /// The samples on the light, each with the time of its ray.
    pub(crate) fn targets(&self) -> &[(DVec3, f64)] {
        &self.targets
    }

    /// The sub-cell of a place on the light's square: column and row.
    pub(crate) fn part(&self, place: [f64; 2]) -> [u32; 2] {
        let parts = self.side * PARTS;
        place.map(|at| ((at * f64::from(parts)) as u32).min(parts - 1))
    }

    /// The index of the cell that holds a sub-cell.
    pub(crate) const fn cell(&self, part: [u32; 2]) -> usize {
        (part[1] / PARTS * self.side + part[0] / PARTS) as usize
    }

    /// The sub-cell of a cell's sample.
    pub(crate) fn sampled_part(&self, cell: usize) -> [u32; 2] {
        self.part(self.places[cell])
    }
}
