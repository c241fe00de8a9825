//! The rasteriser.

use std::sync::{Mutex, PoisonError};

use dsm_core::detail::Result;
use dsm_core::{Error, HitSource, ShadowCamera, TileHits, TileSamples, Transmittance, ViewRaster};
use fearless_simd::Level;
use glam::Vec3;

use super::bins::Bins;
use super::cell_hits::CellHits;
use super::cell_lists::CellLists;
use super::cells::{Cell, CellArea};
use super::layer::{Layer, LayerBuilder};
use super::rays::Rays;
use super::segment::{RaySegment, Segment};
use super::triangle::RayTriangle;

/// A builder of a [`Rasterizer`]: collects its primitives.
///
/// Points are in camera space: right-handed, the camera looks down −z. What
/// moves goes in a straight line from where the shutter opens to where it
/// closes, radii too.
#[derive(Clone, Debug)]
pub struct RasterizerBuilder<T: Transmittance> {
    pub(super) rays: Rays,
    size: [u32; 2],
    pub(super) segments: LayerBuilder<T, RaySegment<1>>,
    pub(super) moving_segments: LayerBuilder<T, RaySegment<2>>,
    pub(super) triangles: LayerBuilder<T, RayTriangle<1>>,
    pub(super) moving_triangles: LayerBuilder<T, RayTriangle<2>>,
}

/// A rasteriser of the hits of one shadow camera's rays: segments of strands and
/// triangles, each of one opacity.
///
/// Made for the rays of one map, it is an order of magnitude faster than a ray
/// tracer. The hits of each pixel come in a fixed order, whatever the block
/// that is asked for, and of the same bits on every processor. Pixels beyond
/// the map are answered like others.
///
/// A ray meets a segment where it passes within its radius ([`Segment`]), a
/// triangle where it crosses it, from either side. Hits behind the camera's
/// plane, or in it, are none. Primitives that are not finite are left out.
///
/// ```
/// use dsm_core::{HitSource, PixelSampling, ShadowCamera, TileHits, TileSamples};
/// use dsm_scene::detail::{RasterizerBuilder, Segment};
/// use glam::{DMat4, DVec4, Vec3};
///
/// // An orthographic camera at the origin, 2 units wide and high.
/// let to_ndc = DMat4::from_cols(
///     DVec4::new(0.5, 0.0, 0.0, 0.0),
///     DVec4::new(0.0, -0.5, 0.0, 0.0),
///     DVec4::Z,
///     DVec4::new(0.5, 0.5, 0.0, 1.0),
/// );
/// let camera =
///     ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) };
///
/// // A level hair, as thick as the fourth part of the map is high.
/// let hair = Segment {
///     ends: [Vec3::new(-2.0, 0.0, -3.0), Vec3::new(2.0, 0.0, -3.0)],
///     radii: [0.25; 2],
///     is_joined: false,
/// };
/// let mut builder = RasterizerBuilder::<f32>::new(&camera, [8, 8])?;
/// builder.segments(0.3, [hair])?;
/// let rasterizer = builder.build()?;
///
/// let samples = TileSamples::new(&PixelSampling::new(16, 0)?, [0, 0], [8, 8], None)?;
/// let mut hits = TileHits::new(samples.len());
/// rasterizer.hits(&samples, &mut hits)?;
/// assert_eq!(hits.surface_count(), 2 * 8 * 16);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Debug)]
pub struct Rasterizer<T: Transmittance> {
    rays: Rays,
    segments: Layer<T, RaySegment<1>>,
    moving_segments: Layer<T, RaySegment<2>>,
    triangles: Layer<T, RayTriangle<1>>,
    moving_triangles: Layer<T, RayTriangle<2>>,
    level: Level,
    /// Hits must lie behind this depth.
    near: f32,
    /// Working memory of threads, kept for the next block.
    scratch: Mutex<Vec<Scratch>>,
}

/// The working memory of a block.
#[derive(Clone, Debug, Default)]
struct Scratch {
    lists: [CellLists; 4],
    cell: Cell,
    cell_hits: CellHits,
}

impl<T: Transmittance> RasterizerBuilder<T> {
    /// A builder for a map of `size` pixels which `camera`'s NDC \[0, 1\]² covers.
    ///
    /// # Errors
    ///
    /// [`Error::Camera`] if a matrix is unknown, or the two don't make a
    /// perspective or orthographic projection along the camera's axis.
    pub fn new(camera: &ShadowCamera, size: [u32; 2]) -> Result<Self> {
        let limit = 1 << 24;
        if let Some(&side) = size.iter().find(|&&side| u64::from(side) > limit) {
            return Err(Error::TooLarge { what: "pixels of a map", count: side.into(), limit });
        }
        Ok(Self::with_rays(Rays::new(camera, size)?, size))
    }

    /// For a map that is seen like this.
    pub(super) fn of_view(view: &ViewRaster) -> Self {
        Self::with_rays(Rays::of_view(view), view.resolution())
    }

    fn with_rays(rays: Rays, size: [u32; 2]) -> Self {
        Self {
            rays,
            size,
            segments: LayerBuilder::default(),
            moving_segments: LayerBuilder::default(),
            triangles: LayerBuilder::default(),
            moving_triangles: LayerBuilder::default(),
        }
    }

    /// Adds segments that stand still.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if the opacity is outside [0, 1] in any channel.
    pub fn segments(
        &mut self,
        opacity: T,
        segments: impl IntoIterator<Item = Segment>,
    ) -> Result<()> {
        let segments = segments
            .into_iter()
            .map(|one| RaySegment::new(&self.rays, [one.corners()], one.is_joined));
        self.segments.extend(&self.rays, checked(opacity)?, segments);
        Ok(())
    }

    /// Adds segments that move: as they are where the shutter opens and closes.
    ///
    /// # Errors
    ///
    /// As [`Self::segments`].
    pub fn moving_segments(
        &mut self,
        opacity: T,
        segments: impl IntoIterator<Item = [Segment; 2]>,
    ) -> Result<()> {
        let segments = segments.into_iter().map(|keys| {
            let corners = keys.map(|segment| segment.corners());
            RaySegment::new(&self.rays, corners, keys[0].is_joined)
        });
        self.moving_segments.extend(&self.rays, checked(opacity)?, segments);
        Ok(())
    }

    /// Adds triangles that stand still.
    ///
    /// # Errors
    ///
    /// As [`Self::segments`].
    pub fn triangles(
        &mut self,
        opacity: T,
        triangles: impl IntoIterator<Item = [Vec3; 3]>,
    ) -> Result<()> {
        let triangles = triangles
            .into_iter()
            .map(|one| RayTriangle::new(&self.rays, [one.map(|corner| corner.as_dvec3())]));
        self.triangles.extend(&self.rays, checked(opacity)?, triangles);
        Ok(())
    }

    /// Adds triangles that move: as they are where the shutter opens and
    /// closes.
    ///
    /// # Errors
    ///
    /// As [`Self::segments`].
    pub fn moving_triangles(
        &mut self,
        opacity: T,
        triangles: impl IntoIterator<Item = [[Vec3; 3]; 2]>,
    ) -> Result<()> {
        let triangles = triangles.into_iter().map(|keys| {
            let keys = keys.map(|corners| corners.map(|corner| corner.as_dvec3()));
            RayTriangle::new(&self.rays, keys)
        });
        self.moving_triangles.extend(&self.rays, checked(opacity)?, triangles);
        Ok(())
    }

    /// Sorts all primitives into the map: O(primitives + squares of 16 × 16
    /// pixels that they touch).
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] for more than 2²⁷ primitives of one kind.
    pub fn build(self) -> Result<Rasterizer<T>> {
        let Self { rays, size, segments, moving_segments, triangles, moving_triangles } = self;
        let most = segments.len().max(moving_segments.len());
        let most = most.max(triangles.len()).max(moving_triangles.len());
        let (count, limit) = (most as u64, Bins::MAX_PRIMITIVES as u64);
        if count > limit {
            return Err(Error::TooLarge { what: "primitives", count, limit });
        }
        let level = Level::new();
        Ok(Rasterizer {
            segments: segments.build(level, &rays, size),
            moving_segments: moving_segments.build(level, &rays, size),
            triangles: triangles.build(level, &rays, size),
            moving_triangles: moving_triangles.build(level, &rays, size),
            rays,
            level,
            near: 0.0,
            scratch: Mutex::default(),
        })
    }
}

fn checked<T: Transmittance>(opacity: T) -> Result<T> {
    if (0..T::CHANNELS).all(|channel| (0.0..=1.0).contains(&opacity.channel(channel))) {
        Ok(opacity)
    } else {
        Err(Error::Setting { setting: "opacity", reason: "it must lie in [0, 1]" })
    }
}

impl<T: Transmittance> Rasterizer<T> {
    /// Leaves out occluders at `depth` or nearer: those between the light and a
    /// camera that was moved back from it.
    #[must_use]
    pub fn beyond(self, depth: f32) -> Self {
        Self { near: depth.max(0.0), ..self }
    }

    /// Sets the level of instructions; the hits stay the same.
    #[cfg(test)]
    pub(super) fn with_level(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    fn meet(
        &self,
        samples: &TileSamples,
        area: &CellArea,
        scratch: &mut Scratch,
        hits: &mut TileHits<T>,
    ) -> Result<()> {
        let Scratch { lists, cell, cell_hits } = scratch;
        let (level, rays) = (self.level, &self.rays);
        self.segments.list(level, area, &mut lists[0]);
        self.moving_segments.list(level, area, &mut lists[1]);
        self.triangles.list(level, area, &mut lists[2]);
        self.moving_triangles.list(level, area, &mut lists[3]);
        let columns = area.columns();
        for (row, y) in (area.min[1]..area.max[1]).enumerate() {
            for (column, x) in (area.min[0]..area.max[0]).enumerate() {
                let items = lists.each_ref().map(|lists| lists.cell(row * columns + column));
                if items.iter().all(|items| items.is_empty()) {
                    continue;
                }
                cell.fill(rays, samples, area.side, x, y);
                cell_hits.near = self.near;
                let of = (rays, samples);
                self.segments.meet(level, cell, items[0], of, cell_hits, hits)?;
                self.moving_segments.meet(level, cell, items[1], of, cell_hits, hits)?;
                self.triangles.meet(level, cell, items[2], of, cell_hits, hits)?;
                self.moving_triangles.meet(level, cell, items[3], of, cell_hits, hits)?;
            }
        }
        Ok(())
    }
}

impl<T: Transmittance> HitSource<T> for Rasterizer<T> {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<()> {
        let area = CellArea::new(samples);
        let idle = || self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = idle().pop().unwrap_or_default();
        let met = self.meet(samples, &area, &mut scratch, hits);
        idle().push(scratch);
        met
    }

    fn has_media(&self) -> bool {
        false
    }
}
