//! The interface of primitives.

use fearless_simd::{Simd, f32x16, mask32x16};

use glam::{DVec3, Vec3};

use super::cells::RayLanes;
use super::corner::Corner;
use super::outline::Rows;
use super::rays::Rays;

/// Something that rays meet at most once.
pub(super) trait Primitive: Copy + Send + Sync + 'static {
    /// Its outline in the map, over the whole shutter.
    type Outline: Rows;

    /// True if it has a normal.
    const HAS_NORMAL: bool;

    /// True if its normal is another for each ray.
    const TURNS: bool;

    /// True if it moves.
    const MOVES: bool;

    /// Projects it. `None` if no ray can meet it: behind the camera, of no
    /// thickness, not finite.
    fn outline(&self, rays: &Rays) -> Option<Self::Outline>;

    /// Its normal in camera space (right-handed, the camera looks down −z) at
    /// `time`, to either side, for a ray of this direction; `None` if it has none.
    fn normal(&self, rays: &Rays, time: f32, ray: DVec3) -> Option<Vec3>;

    /// All its corners.
    fn corners(&self) -> &[Corner];

    /// The rays that hit it, and the depths of the hits.
    fn meet<S: Simd>(&self, simd: S, lanes: &RayLanes<S>) -> (mask32x16<S>, f32x16<S>);
}
