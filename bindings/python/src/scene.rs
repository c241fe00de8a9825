//! Scenes from files.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use deepshadow::Shadow as FrontShadow;
use deepshadow::scene::detail::BUILTIN_SCENES;
use deepshadow::scene::{Scene as FrontScene, TracedScene, open_scene};
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::error::Result;
use crate::light::Light;
use crate::shadow::Shadow;

/// Scene(source)
/// --
///
/// What a shadow camera looks at. source: a scene file (.toml), a model (.obj, .ply, .gltf,
/// .glb, .hair, .vdb, .usd, .usda, .usdc, .usdz), which is looked at from a light of its own,
/// or "builtin:NAME".
///
/// Raises SceneError with the file and the place in it.
#[pyclass(frozen, module = "deepshadow")]
pub(crate) struct Scene {
    scene: FrontScene,
    traced: OnceLock<Arc<TracedScene>>,
}

impl Scene {
    /// Opens a scene without the interpreter's lock.
    pub(crate) fn open(py: Python<'_>, source: &Path) -> Result<Self> {
        let scene = py.detach(|| open_scene(source))?;
        Ok(Self { scene, traced: OnceLock::new() })
    }

    /// The scene of the libraries.
    pub(crate) const fn get(&self) -> &FrontScene {
        &self.scene
    }

    /// The scene with a hierarchy over it, which is built once.
    pub(crate) fn traced(&self, py: Python<'_>) -> Result<Arc<TracedScene>> {
        if let Some(traced) = self.traced.get() {
            return Ok(Arc::clone(traced));
        }
        let traced = Arc::new(py.detach(|| TracedScene::new(&self.scene))?);
        Ok(Arc::clone(self.traced.get_or_init(|| traced)))
    }
}

#[pymethods]
impl Scene {
    #[new]
    fn new(py: Python<'_>, source: PathBuf) -> Result<Self> {
        Self::open(py, &source)
    }

    /// The names that "builtin:NAME" knows.
    #[classmethod]
    fn builtins(_class: &Bound<'_, PyType>) -> Vec<String> {
        BUILTIN_SCENES.iter().map(|name| (*name).to_owned()).collect()
    }

    /// The scene's light.
    #[getter]
    fn light(&self) -> Light {
        Light::of(self.scene.light)
    }

    /// What its files hold that was not understood, a line each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.scene.warnings().to_vec()
    }

    /// shadow(rays=256)
    /// --
    ///
    /// The shadows of the scene's light without a map: rays through the scene itself, this
    /// many from every point, at least 1; a point light takes one unless something moves.
    #[pyo3(signature = (rays=256))]
    fn shadow(&self, py: Python<'_>, rays: u32) -> Result<Shadow> {
        let traced = self.traced(py)?;
        let shadow = FrontShadow::reference(traced, &self.scene, rays.max(1))?;
        Ok(Shadow::new(shadow, 0, None))
    }
}
