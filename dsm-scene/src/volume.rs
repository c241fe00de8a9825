//! Density on a grid of voxels.

use glam::{DAffine3, DMat3, DVec3, IVec3, UVec3};

use crate::bounds::Bounds;

/// Voxels along the side of a brick, as a power of two.
pub(crate) const BRICK_LOG2: i32 = 3;
const BRICK: i32 = 1 << BRICK_LOG2;
pub(crate) const BRICK_VOXELS: usize = 1 << (3 * BRICK_LOG2);

/// A density on a grid of voxels, which stand at whole numbers of index space:
/// trilinear, 0 outside. Only bricks of 8³ voxels that hold something take memory.
///
/// ```
/// use dsm_scene::Volume;
/// use glam::{DVec3, UVec3};
///
/// // Voxels 0.5 apart, whose density rises by 1 from one to the next.
/// let ramp = Volume::from_fn(UVec3::splat(4), DVec3::splat(0.5), DVec3::ZERO, |at| at.x as f32)?;
/// assert_eq!(ramp.density(DVec3::new(0.75, 0.5, 0.5)), 1.5);
/// assert_eq!(ramp.density(DVec3::splat(9.0)), 0.0);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Volume {
    /// From index space to object space.
    pub(crate) to_object: DAffine3,
    /// From directions of object space to index space.
    pub(crate) to_index: DMat3,
    /// The brick that the table begins with, and how many it has each way.
    pub(crate) first_brick: IVec3,
    pub(crate) brick_count: UVec3,
    /// Every brick's place among `values`; 0 is the empty brick.
    pub(crate) table: Vec<u32>,
    pub(crate) values: Vec<f32>,
    /// True for bricks with a cell that can hold density; a cell reaches from a
    /// voxel to the next ones, so that cells begin one brick earlier.
    pub(crate) occupied: Vec<bool>,
    /// The lowest and the highest voxel that was set.
    pub(crate) extent: [IVec3; 2],
    /// Cells beyond those voxels that density reaches into.
    pub(crate) margin: f64,
    pub(crate) largest: f32,
    pub(crate) voxel_count: u64,
}

impl Volume {
    /// Bytes of its bricks.
    pub(crate) fn bytes(&self) -> u64 {
        (4 * (self.table.len() + self.values.len()) + self.occupied.len()) as u64
    }

    /// Number of voxels that were set.
    #[must_use]
    pub fn voxel_count(&self) -> u64 {
        self.voxel_count
    }

    /// The lowest and the highest index that was set; `None` if none was.
    #[must_use]
    pub fn extent(&self) -> Option<[IVec3; 2]> {
        (self.voxel_count > 0).then_some(self.extent)
    }

    /// The largest density of a voxel.
    #[must_use]
    pub fn largest(&self) -> f32 {
        self.largest
    }

    /// The distance between voxels in object space, along each axis of the grid.
    #[must_use]
    pub fn voxel_size(&self) -> DVec3 {
        let DMat3 { x_axis, y_axis, z_axis } = self.to_object.matrix3;
        DVec3::new(x_axis.length(), y_axis.length(), z_axis.length())
    }

    /// The map from index space to object space.
    #[must_use]
    pub fn to_object(&self) -> DAffine3 {
        self.to_object
    }

    /// The density of the voxel at `index`, 0 where none was set.
    #[must_use]
    pub fn voxel(&self, index: IVec3) -> f32 {
        let brick = (index >> BRICK_LOG2).wrapping_sub(self.first_brick).as_uvec3();
        if brick.cmpge(self.brick_count).any() {
            return 0.0;
        }
        let slot = self.table[flat(brick, self.brick_count)] as usize;
        self.values[slot * BRICK_VOXELS + voxel_in_brick(index)]
    }

    /// The density at a point of object space, trilinear between voxels.
    #[must_use]
    pub fn density(&self, point: DVec3) -> f32 {
        let index = self.to_index(point);
        // Far outside, `as` saturates; `voxel` knows that there is nothing.
        let cell = index.floor().clamp(DVec3::splat(-1e9), DVec3::splat(1e9));
        self.cell(cell.as_ivec3()).at(index - cell)
    }

    /// A point of object space in index space.
    pub(crate) fn to_index(&self, point: DVec3) -> DVec3 {
        self.to_index * (point - self.to_object.translation)
    }

    /// A direction of object space in index space.
    pub(crate) fn direction_to_index(&self, direction: DVec3) -> DVec3 {
        self.to_index * direction
    }

    /// The density at the corners of the cell that begins at voxel `first`.
    #[inline]
    pub(crate) fn cell(&self, first: IVec3) -> Cell {
        let within = first & (BRICK - 1);
        if within.cmplt(IVec3::splat(BRICK - 1)).all() {
            let brick = (first >> BRICK_LOG2).wrapping_sub(self.first_brick).as_uvec3();
            if brick.cmpge(self.brick_count).any() {
                return Cell([0.0; 8]);
            }
            let slot = self.table[flat(brick, self.brick_count)] as usize;
            let start = slot * BRICK_VOXELS + voxel_in_brick(first);
            let value = |corner: usize| {
                let step = (corner & 1)
                    + ((corner >> 1 & 1) << BRICK_LOG2)
                    + ((corner >> 2) << (2 * BRICK_LOG2));
                f64::from(self.values[start + step])
            };
            return Cell(std::array::from_fn(value));
        }
        Cell(std::array::from_fn(|corner| {
            let corner = corner as i32;
            let step = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            f64::from(self.voxel(first + step))
        }))
    }

    /// The largest box of cells around `cell` that is known to be handled
    /// alike: the cell alone if there may be density, or the brick of cells
    /// that holds none. The flag tells which.
    pub(crate) fn block(&self, cell: IVec3) -> (IVec3, i32, bool) {
        let brick = cell >> BRICK_LOG2;
        let at = (brick - self.first_brick + 1).as_uvec3();
        let cells = self.brick_count + 1;
        if at.cmplt(cells).all() && self.occupied[flat(at, cells)] {
            (cell, 1, true)
        } else {
            (brick << BRICK_LOG2, BRICK, false)
        }
    }

    /// The cells that can hold density, as a box of index space.
    pub(crate) fn index_bounds(&self) -> Bounds {
        if self.voxel_count == 0 {
            return Bounds::default();
        }
        let [low, high] = self.extent;
        Bounds { min: low.as_dvec3() - self.margin, max: high.as_dvec3() + self.margin }
    }

    /// The box that density reaches, in object space.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let bounds = self.index_bounds();
        bounds.transformed(&self.to_object)
    }
}

/// The density at a cell's corners, x first.
pub(crate) struct Cell([f64; 8]);

impl Cell {
    /// Nothing at any corner.
    pub(crate) const EMPTY: Self = Self([0.0; 8]);

    /// True if there is no density at any corner.
    pub(crate) fn is_empty(&self) -> bool {
        self.0 == [0.0; 8]
    }

    /// The density `within` the cell, a point of [0, 1]³.
    #[inline]
    pub(crate) fn at(&self, within: DVec3) -> f32 {
        let part = within.clamp(DVec3::ZERO, DVec3::ONE);
        let mix = |a: f64, b: f64, part: f64| a * (1.0 - part) + b * part;
        let [a, b, c, d, e, f, g, h] = self.0;
        let front = mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
        let back = mix(mix(e, f, part.x), mix(g, h, part.x), part.y);
        mix(front, back, part.z) as f32
    }
}

pub(crate) fn voxel_in_brick(index: IVec3) -> usize {
    let within = index & (BRICK - 1);
    (within.x + (within.y << BRICK_LOG2) + (within.z << (2 * BRICK_LOG2))) as usize
}

pub(crate) fn flat(at: UVec3, size: UVec3) -> usize {
    at.x as usize + size.x as usize * (at.y as usize + size.y as usize * at.z as usize)
}
