//! What the tests share: scenes that are ready, and how they are baked.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use dsm_core::{BakeSettings, Baker, DeepMap, HitSource, Transmittance, ViewRaster};
use dsm_io::detail::{BakeOptions, BakeReport};
use dsm_io::{Limits, MapReader};
use dsm_scene::detail::SceneHitSource;
use dsm_scene::{Error, Scene, SceneRasterizer, TracedScene, open_scene};

/// A real file, or `None` with a note where there are none.
pub(crate) fn real_file(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(name);
    if path.exists() {
        return Some(path.canonicalize().unwrap());
    }
    println!("SKIPPED: {} is not there", path.display());
    None
}

/// Writes a scene file with these contents and opens it. Its models lie in
/// `folder`, or have absolute paths.
pub(crate) fn scene_file(folder: &Path, text: &str) -> Stage {
    let path = folder.join("scene.toml");
    std::fs::write(&path, text).unwrap();
    Stage::new(open_scene(&path).unwrap())
}

/// A scene that is ready to be baked.
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) traced: Arc<TracedScene>,
}

impl Stage {
    pub(crate) fn new(scene: Scene) -> Self {
        let traced = Arc::new(TracedScene::new(&scene).unwrap());
        Self { scene, traced }
    }

    pub(crate) fn builtin(name: &str) -> Self {
        Self::new(open_scene(format!("builtin:{name}").as_ref()).unwrap())
    }

    pub(crate) fn raster(&self, size: [u32; 2]) -> ViewRaster {
        self.scene.light.raster(size).unwrap()
    }

    /// A whole map of `size` pixels with 16 samples each.
    pub(crate) fn settings(&self, size: [u32; 2]) -> BakeSettings {
        let camera = Some(self.raster(size).shadow_camera());
        BakeSettings::new(size).unwrap().with_camera(camera)
    }

    /// A baker of rays that are traced one by one, each hit to the last bit.
    pub(crate) fn baker<T: Transmittance>(
        &self,
        settings: &BakeSettings,
    ) -> Baker<T, impl HitSource<T, Error = Error> + '_> {
        let source = SceneHitSource::new(Arc::clone(&self.traced), self.raster(settings.size));
        Baker::new(source, settings.clone()).unwrap()
    }

    /// Bakes as the program does: what can be is rasterised, and its depths are
    /// rounded otherwise.
    pub(crate) fn rasterized<T: Transmittance>(&self, settings: &BakeSettings) -> DeepMap<T> {
        let source = SceneRasterizer::<T>::new(&self.scene, self.raster(settings.size)).unwrap();
        Baker::new(source, settings.clone()).unwrap().map().unwrap()
    }

    /// Bakes into the file `path`.
    pub(crate) fn bake_as<T: Transmittance>(
        &self,
        settings: &BakeSettings,
        options: &BakeOptions,
        path: &Path,
    ) -> BakeReport {
        let never = |_| ControlFlow::Continue(());
        dsm_io::detail::bake(&self.baker::<T>(settings), path, options, |_| (), never).unwrap()
    }

    /// Bakes into a file, which has to be sound, and reads it.
    pub(crate) fn bake<T: Transmittance>(&self, settings: &BakeSettings) -> DeepMap<T> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.dsm");
        let report = self.bake_as::<T>(settings, &BakeOptions::default(), &path);
        assert_eq!(report.bytes, path.metadata().unwrap().len());
        open(&path).read_map(0).unwrap()
    }
}

/// Opens a file that has to be sound.
pub(crate) fn open(path: &Path) -> MapReader {
    let reader = MapReader::open(path, &Limits::default()).unwrap();
    assert!(reader.verify().is_empty(), "{:?}", reader.verify());
    reader
}
