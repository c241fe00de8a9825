//! Volumes that are made voxel by voxel.

use std::collections::{HashMap, HashSet};

use glam::{DAffine3, DMat3, DVec3, IVec3, UVec3};

use crate::bricks::Bricks;
use crate::error::{Error, Place, Result};
use crate::volume::{BRICK_LOG2, BRICK_VOXELS, Volume, flat, voxel_in_brick};

/// The largest number of bricks in the box around all of them: 64 MiB of table.
const MAX_BRICKS: u64 = 1 << 24;
/// The largest distance of a voxel from the origin, along an axis.
const MAX_COORDINATE: i32 = 1 << 28;

/// A builder of a [`Volume`], voxel by voxel.
///
/// ```
/// use dsm_scene::VolumeBuilder;
/// use glam::{DVec3, IVec3};
///
/// let mut builder = VolumeBuilder::default();
/// builder.set(IVec3::ZERO, 1.0)?;
/// let volume = builder.build(DVec3::ONE, DVec3::ZERO)?;
/// assert_eq!(volume.voxel_count(), 1);
/// assert_eq!(volume.density(DVec3::new(0.5, 0.0, 0.0)), 0.5);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Debug)]
pub struct VolumeBuilder {
    bricks: Bricks,
    values: Vec<f32>,
    constants: HashMap<u32, u32>,
    shared: HashSet<u32>,
    extent: [IVec3; 2],
    background: f32,
    largest: f32,
    voxel_count: u64,
}

impl Default for VolumeBuilder {
    fn default() -> Self {
        Self {
            bricks: Bricks::default(),
            values: vec![0.0; BRICK_VOXELS],
            constants: HashMap::new(),
            shared: HashSet::new(),
            extent: [IVec3::MAX, IVec3::MIN],
            background: 0.0,
            largest: 0.0,
            voxel_count: 0,
        }
    }
}

impl VolumeBuilder {
    /// Sets the voxel at `index`; values below 0 count as 0.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a value that is not finite or an index beyond
    /// ±2²⁸; [`Error::TooLarge`] above 2²⁴ bricks of 8³ voxels.
    pub fn set(&mut self, index: IVec3, value: f32) -> Result<()> {
        let value = self.note(index, index, value, 1)?;
        self.write(index, value)
    }

    /// Sets what lies around the voxels that are set, up to one voxel beyond their
    /// box: 0 unless it is set.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a value that is not finite.
    pub(crate) fn set_background(&mut self, value: f32) -> Result<()> {
        if !value.is_finite() {
            let reason = format!("the background must be finite, not {value}");
            return Err(Error::malformed(Place::Whole, reason));
        }
        self.background = value.max(0.0);
        Ok(())
    }

    /// Sets the voxel at `index` to what counts only where the box of the others
    /// reaches.
    pub(crate) fn set_outside(&mut self, index: IVec3, value: f32) -> Result<()> {
        let value = check_voxel(index, index, value)?;
        self.write(index, value)
    }

    fn write(&mut self, index: IVec3, value: f32) -> Result<()> {
        let brick = index >> BRICK_LOG2;
        let slot = match self.bricks.get(brick) {
            Some(slot) if !self.shared.contains(&slot) => slot,
            shared => {
                // A brick of its own, filled like the one that it shared.
                let from = shared.map_or(0, |slot| slot as usize * BRICK_VOXELS);
                let slot = (self.values.len() / BRICK_VOXELS) as u32;
                self.values.extend_from_within(from..from + BRICK_VOXELS);
                self.insert(brick, slot)?;
                slot
            }
        };
        self.values[slot as usize * BRICK_VOXELS + voxel_in_brick(index)] = value;
        Ok(())
    }

    /// Sets all `side`³ voxels from `index` on, which has to be a multiple of
    /// 8 as `side` is. Bricks that are filled with one value share memory.
    ///
    /// # Errors
    ///
    /// See [`Self::set`].
    pub fn fill(&mut self, index: IVec3, side: i32, value: f32) -> Result<()> {
        let voxels = u64::from(side.unsigned_abs()).pow(3);
        let end = index.saturating_add(IVec3::splat(side - 1));
        let value = self.note(index, end, value, voxels)?;
        let slot = *self.constants.entry(value.to_bits()).or_insert_with(|| {
            let slot = (self.values.len() / BRICK_VOXELS) as u32;
            self.values.resize(self.values.len() + BRICK_VOXELS, value);
            slot
        });
        self.shared.insert(slot);
        let (first, last) = (index >> BRICK_LOG2, end >> BRICK_LOG2);
        if self.bricks.fill(first, last, slot, MAX_BRICKS) {
            return Ok(());
        }
        check_bricks(self.bricks.count())
    }

    fn insert(&mut self, brick: IVec3, slot: u32) -> Result<()> {
        self.bricks.insert(brick, slot);
        check_bricks(self.bricks.count())
    }

    fn note(&mut self, first: IVec3, last: IVec3, value: f32, voxels: u64) -> Result<f32> {
        let value = check_voxel(first, last, value)?;
        self.extent = [self.extent[0].min(first), self.extent[1].max(last)];
        self.largest = self.largest.max(value);
        self.voxel_count += voxels;
        Ok(value)
    }

    /// The volume, whose voxels are `voxel_size` apart and whose voxel
    /// (0, 0, 0) lies at `translation` of object space.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for sizes that are not finite or not positive;
    /// [`Error::TooLarge`] if the box around all voxels holds more than 2²⁴
    /// bricks.
    pub fn build(self, voxel_size: DVec3, translation: DVec3) -> Result<Volume> {
        self.build_placed(DAffine3 { matrix3: DMat3::from_diagonal(voxel_size), translation })
    }

    /// The volume, whose index space lies in object space as `to_object` says.
    ///
    /// # Errors
    ///
    /// As [`Self::build`]; also for a transform that cannot be undone.
    pub fn build_placed(mut self, to_object: DAffine3) -> Result<Volume> {
        let to_index = check_transform(&to_object)?;
        let (mut first, mut last) = (IVec3::ZERO, IVec3::NEG_ONE);
        let mut margin = 1.0;
        if self.voxel_count > 0 {
            if self.background > 0.0 {
                self.extent[0] -= 1;
                self.extent[1] += 1;
                self.largest = self.largest.max(self.background);
                margin = 0.0;
            }
            (first, last) = (self.extent[0] >> BRICK_LOG2, self.extent[1] >> BRICK_LOG2);
        }
        let brick_count = (last - first + 1).as_uvec3();
        let sides = brick_count.to_array().map(u64::from);
        check_bricks(sides.into_iter().fold(1, u64::saturating_mul))?;
        let mut around = 0;
        if self.background > 0.0 {
            around = (self.values.len() / BRICK_VOXELS) as u32;
            self.values.resize(self.values.len() + BRICK_VOXELS, self.background);
        }
        let mut table = vec![around; brick_count.element_product() as usize];
        // What is outside the box that the others make is not looked at.
        for (brick, slot) in self.bricks.within(first, last) {
            table[flat((brick - first).as_uvec3(), brick_count)] = slot;
        }
        let bricks = self.values.as_chunks::<BRICK_VOXELS>().0.iter();
        let is_empty: Vec<bool> =
            bricks.map(|values| values.iter().all(|&value| value == 0.0)).collect();
        let cells = brick_count + 1;
        let mut occupied = vec![false; cells.to_array().map(|side| side as usize).iter().product()];
        for (index, &slot) in (0..).zip(&table) {
            if is_empty[slot as usize] {
                continue;
            }
            for corner in 0..8 {
                let back = UVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
                occupied[flat(unflat(index, brick_count).as_uvec3() + 1 - back, cells)] = true;
            }
        }
        Ok(Volume {
            to_object,
            to_index,
            first_brick: first,
            brick_count,
            table,
            values: self.values,
            occupied,
            extent: self.extent,
            margin,
            largest: self.largest,
            voxel_count: self.voxel_count,
        })
    }
}

impl Volume {
    /// A volume of `size` voxels from index (0, 0, 0) on, filled by `density`.
    ///
    /// # Errors
    ///
    /// See [`VolumeBuilder::set`] and [`VolumeBuilder::build`].
    pub fn from_fn(
        size: UVec3,
        voxel_size: DVec3,
        translation: DVec3,
        mut density: impl FnMut(IVec3) -> f32,
    ) -> Result<Self> {
        let mut builder = VolumeBuilder::default();
        let size = size.min(UVec3::splat(MAX_COORDINATE as u32)).as_ivec3();
        for z in 0..size.z {
            for y in 0..size.y {
                for x in 0..size.x {
                    let index = IVec3::new(x, y, z);
                    let value = density(index);
                    // Voxels that hold nothing are left out: their bricks may be.
                    if value != 0.0 {
                        builder.set(index, value)?;
                    }
                }
            }
        }
        builder.build(voxel_size, translation)
    }
}

fn unflat(index: u64, size: UVec3) -> IVec3 {
    let [x, y] = [size.x, size.y].map(u64::from);
    let [x, y, z] = [index % x, index / x % y, index / (x * y)].map(|at| at as i32);
    IVec3::new(x, y, z)
}

/// The value that counts of one for all voxels from `first` to `last`.
fn check_voxel(first: IVec3, last: IVec3, value: f32) -> Result<f32> {
    let place = || Place::Voxel(first.to_array());
    if !value.is_finite() {
        return Err(Error::malformed(place(), format!("density must be finite, not {value}")));
    }
    let far = IVec3::splat(MAX_COORDINATE);
    if first.cmplt(-far).any() || last.cmpgt(far).any() {
        return Err(Error::malformed(place(), "voxels may lie within ±2^28 only"));
    }
    Ok(value.max(0.0))
}

/// The inverse of a transform that can be undone.
fn check_transform(to_object: &DAffine3) -> Result<DMat3> {
    let DAffine3 { matrix3, translation } = to_object;
    let sound = |axis: DVec3| (1e-18..=1e18).contains(&axis.length());
    let axes = [matrix3.x_axis, matrix3.y_axis, matrix3.z_axis];
    let refuse = |reason| Err(Error::malformed(Place::Named("transform".into()), reason));
    if !(axes.into_iter().all(sound) && translation.abs().cmple(DVec3::splat(1e18)).all()) {
        return refuse("voxels must be 1e-18 to 1e18 units large, at most 1e18 units away");
    }
    // The volume of the cell of unit axes: sizes have no part in it.
    let [x, y, z] = axes.map(DVec3::normalize);
    let inverse = matrix3.inverse();
    if x.dot(y.cross(z)).abs() < 1e-9 || !inverse.is_finite() {
        return refuse("it has no inverse");
    }
    Ok(inverse)
}

fn check_bricks(count: u64) -> Result<()> {
    if count > MAX_BRICKS {
        let what = "bricks of 8 × 8 × 8 voxels in the box around a volume";
        return Err(Error::TooLarge { what, count, limit: MAX_BRICKS });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_share_one_brick_a_value() {
        let mut builder = VolumeBuilder::default();
        builder.fill(IVec3::new(-128, 0, 128), 128, 2.0).unwrap();
        builder.fill(IVec3::new(0, 0, 128), 8, 2.0).unwrap();
        let volume = builder.build(DVec3::ONE, DVec3::ZERO).unwrap();
        assert_eq!(volume.values.len(), 2 * BRICK_VOXELS);
        assert_eq!(volume.voxel(IVec3::new(-1, 127, 255)), 2.0);
        assert_eq!(volume.voxel(IVec3::new(7, 7, 135)), 2.0);
        assert_eq!(volume.voxel(IVec3::new(8, 7, 135)), 0.0);
        assert_eq!(volume.voxel_count(), 128 * 128 * 128 + 512);
        // A voxel set within a tile changes no other tile.
        let mut builder = VolumeBuilder::default();
        builder.fill(IVec3::ZERO, 16, 2.0).unwrap();
        builder.set(IVec3::ONE, 3.0).unwrap();
        let volume = builder.build(DVec3::ONE, DVec3::ZERO).unwrap();
        let values = [0, 1, 9].map(|index| volume.voxel(IVec3::splat(index)));
        assert_eq!(values, [2.0, 3.0, 2.0]);
    }

    #[test]
    fn volumes_no_memory_could_hold_are_refused() {
        let mut builder = VolumeBuilder::default();
        builder.set(IVec3::ZERO, 1.0).unwrap();
        builder.set(IVec3::splat(MAX_COORDINATE), 1.0).unwrap();
        assert!(matches!(builder.build(DVec3::ONE, DVec3::ZERO), Err(Error::TooLarge { .. })));
        let mut builder = VolumeBuilder::default();
        assert!(builder.set(IVec3::splat(i32::MIN), 1.0).is_err());
        assert!(builder.fill(IVec3::splat(i32::MAX - 7), 8, 1.0).is_err());
        assert!(builder.set(IVec3::ZERO, f32::NAN).is_err());
        let empty = VolumeBuilder::default().build(DVec3::ONE, DVec3::ZERO).unwrap();
        assert!(empty.bounds().is_empty() && empty.density(DVec3::ZERO) == 0.0);
        assert!(VolumeBuilder::default().build(DVec3::ZERO, DVec3::ZERO).is_err());
    }

    #[test]
    fn density_is_trilinear_between_voxels() {
        let value = |index: IVec3| (index.x + 10 * index.y + 100 * index.z + 1) as f32;
        let size = DVec3::new(0.5, 0.25, 2.0);
        let volume =
            Volume::from_fn(UVec3::new(20, 9, 11), size, DVec3::new(1.0, 2.0, 3.0), value).unwrap();
        assert_eq!(volume.voxel_count(), 20 * 9 * 11);
        assert_eq!(volume.extent(), Some([IVec3::ZERO, IVec3::new(19, 8, 10)]));
        // A trilinear function comes back between bricks, too.
        for index in [[0.0, 0.0, 0.0], [7.5, 7.25, 7.75], [3.3, 2.1, 9.9], [15.9, 7.9, 8.1]] {
            let index = DVec3::from(index);
            let point = index * size + DVec3::new(1.0, 2.0, 3.0);
            let expected = index.x + 10.0 * index.y + 100.0 * index.z + 1.0;
            assert!((f64::from(volume.density(point)) - expected).abs() < 1e-3, "{index}");
        }
        // Half a voxel outside, half of it.
        let outside = volume.density(DVec3::new(0.75, 2.0, 3.0));
        assert!((outside - 0.5).abs() < 1e-6);
        assert_eq!(volume.density(DVec3::splat(1e30)), 0.0);
        assert_eq!(volume.density(DVec3::splat(-1e30)), 0.0);
    }
}
