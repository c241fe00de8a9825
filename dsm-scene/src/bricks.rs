//! Where the bricks of a volume are while it is built.

use std::collections::HashMap;

use glam::IVec3;

/// Bricks along the side of a region, as a power of two.
const REGION_LOG2: i32 = 4;
const REGION: i32 = 1 << REGION_LOG2;
const REGION_BRICKS: usize = 1 << (3 * REGION_LOG2);
/// No brick.
const NONE: u32 = u32::MAX;

/// A slot for every brick that is set, in regions of 16³ bricks: one that is filled
/// takes no more memory than one number.
#[derive(Debug, Default)]
pub(crate) struct Bricks {
    regions: HashMap<IVec3, Region>,
    count: u64,
}

#[derive(Debug)]
enum Region {
    /// All bricks have one slot.
    Filled(u32),
    /// Every brick's slot, or none.
    Mixed(Box<[u32; REGION_BRICKS]>),
}

impl Region {
    fn slot(&self, brick: IVec3) -> Option<u32> {
        let slot = match self {
            Self::Filled(slot) => *slot,
            Self::Mixed(slots) => slots[place_in_region(brick)],
        };
        (slot != NONE).then_some(slot)
    }

    fn count(&self) -> u64 {
        match self {
            Self::Filled(_) => REGION_BRICKS as u64,
            Self::Mixed(slots) => slots.iter().filter(|&&slot| slot != NONE).count() as u64,
        }
    }
}

impl Bricks {
    /// How many bricks are set.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    pub(crate) fn get(&self, brick: IVec3) -> Option<u32> {
        self.regions.get(&(brick >> REGION_LOG2))?.slot(brick)
    }

    pub(crate) fn insert(&mut self, brick: IVec3, slot: u32) {
        let region = self.regions.entry(brick >> REGION_LOG2);
        let region = region.or_insert_with(|| Region::Mixed(Box::new([NONE; REGION_BRICKS])));
        if let Region::Filled(filled) = *region {
            *region = Region::Mixed(Box::new([filled; REGION_BRICKS]));
        }
        if let Region::Mixed(slots) = region {
            let place = &mut slots[place_in_region(brick)];
            self.count += u64::from(*place == NONE);
            *place = slot;
        }
    }

    /// Gives all bricks from `first` to `last` one slot; no more than `most` are set
    /// then, or a few of them are not: whether they are.
    pub(crate) fn fill(&mut self, first: IVec3, last: IVec3, slot: u32, most: u64) -> bool {
        let [first_region, last_region] = [first, last].map(|brick| brick >> REGION_LOG2);
        for at in boxed(first_region, last_region) {
            let low = at << REGION_LOG2;
            let (start, end) = (first.max(low), last.min(low + (REGION - 1)));
            if start == low && end == low + (REGION - 1) {
                let before = self.regions.insert(at, Region::Filled(slot));
                self.count += REGION_BRICKS as u64 - before.map_or(0, |before| before.count());
            } else {
                boxed(start, end).for_each(|brick| self.insert(brick, slot));
            }
            if self.count > most {
                return false;
            }
        }
        true
    }

    /// The bricks within a box, with their slots, in no order.
    pub(crate) fn within(
        &self,
        first: IVec3,
        last: IVec3,
    ) -> impl Iterator<Item = (IVec3, u32)> + '_ {
        self.regions.iter().flat_map(move |(&at, region)| {
            let low = at << REGION_LOG2;
            let bricks = boxed(first.max(low), last.min(low + (REGION - 1)));
            bricks.filter_map(move |brick| Some((brick, region.slot(brick)?)))
        })
    }
}

fn place_in_region(brick: IVec3) -> usize {
    let within = brick & (REGION - 1);
    (within.x + (within.y << REGION_LOG2) + (within.z << (2 * REGION_LOG2))) as usize
}

/// All places of a box, its last corner among them; none if that lies before the first.
fn boxed(first: IVec3, last: IVec3) -> impl Iterator<Item = IVec3> {
    (first.z..=last.z).flat_map(move |z| {
        (first.y..=last.y).flat_map(move |y| (first.x..=last.x).map(move |x| IVec3::new(x, y, z)))
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn bricks_are_what_was_set_last() {
        let mut bricks = Bricks::default();
        let mut naive = BTreeMap::new();
        let mut state = 1_u32;
        let mut next = |below: i32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as i32 % below
        };
        for slot in 0..300 {
            let first = IVec3::new(next(80) - 40, next(80) - 40, next(80) - 40);
            if next(3) > 0 {
                bricks.insert(first, slot);
                naive.insert(first.to_array(), slot);
                continue;
            }
            // Cubes, some of them whole regions.
            let is_aligned = next(2) == 0;
            let first = if is_aligned { first >> 4 << 4 } else { first };
            let side = if is_aligned { 16 } else { 1 + next(20) };
            let last = first + (side - 1);
            assert!(bricks.fill(first, last, slot, 1 << 20));
            naive.extend(boxed(first, last).map(|brick| (brick.to_array(), slot)));
        }
        assert_eq!(bricks.count(), naive.len() as u64);
        let (first, last) = (IVec3::splat(-30), IVec3::new(30, 50, 10));
        for brick in boxed(IVec3::splat(-45), IVec3::splat(60)) {
            assert_eq!(bricks.get(brick), naive.get(&brick.to_array()).copied(), "{brick}");
        }
        let found: BTreeMap<_, _> =
            bricks.within(first, last).map(|(brick, slot)| (brick.to_array(), slot)).collect();
        naive.retain(|&brick, _| {
            let brick = IVec3::from(brick);
            brick.cmpge(first).all() && brick.cmple(last).all()
        });
        assert_eq!(found, naive);
        assert!(!bricks.fill(IVec3::splat(100), IVec3::splat(400), 0, 1 << 20));
    }
}
