//! What a map shows, and from where.

use dsm_core::MapInfo;
use dsm_core::detail::MapProjection;
use dsm_scene::Light;
use glam::{DAffine3, DVec3};

use crate::error::Result;
use crate::shadow_map::ShadowMap;

/// How far two lights' places may be apart, of the numbers they are computed from, and
/// their directions: maps of deep OpenEXRs hold matrices of 32-bit floats.
const APART: f64 = 1e-5;

/// The view of a map: where its light stands, and which points of the world lie in it.
///
/// ```
/// use deepshadow::glam::DVec3;
/// use deepshadow::{Bake, ShadowMap, bake};
///
/// let scene = deepshadow::scene::builtin_scene("spinning-sphere")?;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("sphere.dsm");
/// let go_on = |_| std::ops::ControlFlow::Continue(());
/// bake(&scene, &scene.light, &Bake::new([8, 8])?, &path, go_on)?;
///
/// let view = ShadowMap::open(&path)?.view()?.unwrap();
/// assert!(view.is_of(&scene.light) && view.shows(scene.light.view.target));
/// assert!(!view.shows(scene.light.view.eye * 1e6));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MapView {
    projection: MapProjection,
    size: [f64; 2],
    to_world: DAffine3,
    /// The depth of the light's centre: maps of area lights are seen from behind it.
    light_depth: f64,
}

impl MapView {
    fn new(info: &MapInfo, size: [u32; 2], light_depth: f64) -> Result<Option<Self>> {
        let camera = info.camera.filter(|camera| camera.world_to_ndc.is_some());
        let Some(to_camera) = camera.and_then(|camera| camera.world_to_camera) else {
            return Ok(None);
        };
        let projection = MapProjection::new(info, size)?;
        let to_world = DAffine3::from_mat4(to_camera).inverse();
        Ok(Some(Self { projection, size: size.map(f64::from), to_world, light_depth }))
    }

    /// The light's centre in the world.
    #[must_use]
    pub fn light(&self) -> DVec3 {
        self.to_world.transform_point3(DVec3::NEG_Z * self.light_depth)
    }

    /// True if a point lies within the map's pixels and deeper than its light: what
    /// does not is lit, whatever the map holds.
    #[must_use]
    pub fn shows(&self, point: DVec3) -> bool {
        let [width, height] = self.size;
        self.projection.project(point).is_some_and(|at| self.holds(at, width, height))
    }

    /// The same of a point in the map's raster: a position in pixels and a depth.
    #[must_use]
    pub fn shows_raster(&self, point: [f64; 3]) -> bool {
        let [width, height] = self.size;
        self.holds(point.into(), width, height)
    }

    fn holds(&self, at: DVec3, width: f64, height: f64) -> bool {
        let inside = (0.0..width).contains(&at.x) && (0.0..height).contains(&at.y);
        inside && at.z > self.light_depth
    }

    /// True if the map is seen from this light: from its centre, or from behind it, in
    /// its direction.
    #[must_use]
    pub fn is_of(&self, light: &Light) -> bool {
        let (eye, target) = (light.view.eye, light.view.target);
        let scale = eye.abs().max(target.abs()).max_element();
        let ahead = self.to_world.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
        let apart = (self.light() - eye).length();
        let turned = (ahead - (target - eye).normalize_or_zero()).length();
        apart <= APART * scale.max((target - eye).length()) && turned <= 2.0 * APART
    }

    /// The side of a pixel of level 0 in scene units, at a depth on the map's axis.
    #[must_use]
    pub fn pixel_size(&self, depth: f64) -> f64 {
        let on_axis = DVec3::NEG_Z * depth;
        let column = |at: DVec3| {
            let projected = self.projection.project(self.to_world.transform_point3(at));
            projected.map_or(f64::NAN, |raster| raster.x)
        };
        depth / (column(on_axis + DVec3::X * depth) - column(on_axis)).abs()
    }
}

impl ShadowMap {
    /// What the map shows, and from where; `None` of a map without a camera.
    ///
    /// # Errors
    ///
    /// [`Error::Core`](crate::Error::Core) for a camera that is none,
    /// [`Error::File`](crate::Error::File) for metadata that is no JSON.
    pub fn view(&self) -> Result<Option<MapView>> {
        MapView::new(self.info(), self.size(), self.light_depth()?)
    }

    /// The depth of the light's centre on the camera's axis.
    pub(crate) fn light_depth(&self) -> Result<f64> {
        let keys = self.kind_metadata()?;
        let light_depth = keys.pointer("/layering/light_depth").and_then(serde_json::Value::as_f64);
        Ok(light_depth.unwrap_or(0.0))
    }
}
