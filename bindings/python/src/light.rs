//! Lights: where they stand, what they look at, how large they are.

use deepshadow::glam::DVec3;
use deepshadow::scene::Light as SceneLight;
use deepshadow::visibility::{LightExtent, Projection, View};
use pyo3::prelude::*;

use crate::error::{Failure, Result};

/// Full angle of the wider side where none is told, in degrees.
const USUAL_ANGLE: f64 = 45.0;

/// Light(eye, target, up=(0, 1, 0), *, fov=None, extent=None, shape=None, size=None, radius=None)
/// --
///
/// A light and the camera that sits in it.
///
/// eye, target, up: points and a direction of the world. fov: full angle of the wider side
/// in degrees, in (0, 180), default 45; or extent: its full width in scene units, of a light
/// with parallel rays. shape: "point", "rectangle" with size=(width, height), "disk" or
/// "sphere" with radius, all in scene units.
///
/// Raises SettingError for what is no light.
#[pyclass(frozen, module = "deepshadow")]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light(SceneLight);

impl Light {
    pub(crate) const fn of(light: SceneLight) -> Self {
        Self(light)
    }

    /// The light of the libraries.
    pub(crate) const fn get(&self) -> &SceneLight {
        &self.0
    }
}

#[pymethods]
impl Light {
    #[new]
    #[pyo3(signature = (eye, target, up=[0.0, 1.0, 0.0], *, fov=None, extent=None, shape=None,
                        size=None, radius=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments")]
    fn new(
        eye: [f64; 3],
        target: [f64; 3],
        up: [f64; 3],
        fov: Option<f64>,
        extent: Option<f64>,
        shape: Option<&str>,
        size: Option<[f64; 2]>,
        radius: Option<f64>,
    ) -> Result<Self> {
        let projection = match (fov, extent) {
            (Some(_), Some(_)) => return Err(Failure::setting("fov or extent, not both")),
            (None, Some(extent)) => Projection::Orthographic { extent },
            (fov, None) => Projection::Perspective { fov: fov.unwrap_or(USUAL_ANGLE) },
        };
        let extent = match (shape, size, radius) {
            (None | Some("point"), None, None) => LightExtent::POINT,
            (None | Some("rectangle"), Some(size), None) => LightExtent::rectangle(size),
            (Some("disk"), None, Some(radius)) => LightExtent::disk(radius),
            (Some("sphere"), None, Some(radius)) => LightExtent::sphere(radius),
            _ => {
                let reason = "a light is a point, a rectangle with a size, or a disk or a sphere \
                              with a radius";
                return Err(Failure::setting(reason));
            }
        };
        let [eye, target, up] = [eye, target, up].map(DVec3::from);
        let light = SceneLight { view: View { eye, target, up }, projection, extent };
        light.area()?;
        light.raster([1, 1])?;
        Ok(Self(light))
    }

    /// Where it stands, in the world.
    #[getter]
    fn eye(&self) -> [f64; 3] {
        self.0.view.eye.to_array()
    }

    /// What it looks at, in the world.
    #[getter]
    fn target(&self) -> [f64; 3] {
        self.0.view.target.to_array()
    }

    /// Its upwards direction, in the world.
    #[getter]
    fn up(&self) -> [f64; 3] {
        self.0.view.up.to_array()
    }

    /// "point", "rectangle", "disk" or "sphere".
    #[getter]
    fn shape(&self) -> &'static str {
        self.0.extent.shape().name()
    }

    /// Full width and height in scene units; of a disk or a sphere the diameter.
    #[getter]
    fn size(&self) -> [f64; 2] {
        self.0.extent.size()
    }

    fn __repr__(&self) -> String {
        let [x, y, z] = self.eye();
        format!("<deepshadow.Light: {} at ({x}, {y}, {z})>", self.shape())
    }
}
