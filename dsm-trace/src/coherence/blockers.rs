//! The blockers that the receivers before have met.

use dsm_core::AreaLight;
use glam::DVec3;

use super::light_cells::{LightCells, PARTS};
use super::prediction::{Cell, Prediction};

/// Where a ray met an occluder, and what was left of its light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocker {
    pub(crate) point: DVec3,
    /// [`Cell::Blocked`] or [`Cell::Partial`].
    pub(crate) kind: Cell,
}

/// The list of blockers, oldest first: at most one a sub-cell of the light, as the
/// receiver that comes sees them (§5.2.2).
#[derive(Debug, Default)]
pub(crate) struct Blockers {
    list: Vec<Blocker>,
    /// For each sub-cell the receiver that put a blocker there last.
    taken: Vec<u32>,
    receiver: u32,
}

impl Blockers {
    pub(crate) fn clear(&mut self) {
        self.list.clear();
    }

    pub(crate) fn push(&mut self, blocker: Blocker) {
        self.list.push(blocker);
    }

    /// Marks the cells that blockers lie in front of, and drops the blockers that
    /// lie in front of none or of a sub-cell that has a newer one. O(blockers).
    pub(crate) fn project(
        &mut self,
        receiver: DVec3,
        light: &AreaLight,
        cells: &LightCells,
        covers: bool,
        prediction: &mut Prediction,
    ) {
        let parts = prediction.side() * PARTS;
        self.taken.resize((parts * parts) as usize, 0);
        self.receiver = self.receiver.wrapping_add(1);
        if self.receiver == 0 {
            self.taken.fill(0);
            self.receiver = 1;
        }
        self.list.reverse();
        let (taken, receiver_number) = (&mut self.taken, self.receiver);
        self.list.retain(|blocker| {
            let Some(place) = light.behind(receiver, blocker.point) else { return false };
            let part = cells.part(place);
            let last = &mut taken[(part[1] * parts + part[0]) as usize];
            if *last == receiver_number {
                return false;
            }
            *last = receiver_number;
            let cell = cells.cell(part);
            let is_sample = covers && cells.sampled_part(cell) == part;
            prediction.mark(cell, blocker.kind, is_sample);
            true
        });
        self.list.reverse();
    }
}
