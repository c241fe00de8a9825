//! Bakes.

use std::path::{Path, PathBuf};

use deepshadow::files::deep_exr::Selection;
use deepshadow::files::{ConvertOptions, Limits, MapSource};
use deepshadow::visibility::Progress;
use deepshadow::{Bake, BakeReport, Channels, Error, ShadowMap};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::bake_settings;
use crate::error::{Failure, Result};
use crate::light::Light;
use crate::map::Map;
use crate::options::Options;
use crate::progress::run;
use crate::scene::Scene;
use crate::source::PythonOccluders;

/// bake(source, output, *, light=None, media=False, threads=None, progress=None, **settings)
/// --
///
/// Bakes a map into the file output (.dsm), which is replaced when the map is whole, and
/// returns a dict of counts: samples, hits, cut_pixels, gained, tolerance, channels, bytes,
/// smaller_tiles, warnings.
///
/// source: a Scene, a scene file or model, or "builtin:NAME"; of kind prefiltered also a Map,
/// a map's file or a deep .exr; or a function of the arrays x, y (float64, in pixels from the
/// left and the top edge) and time (float32, in [0, 1]) of many sample points. It returns
/// arrays (sample, depth, opacity): for each hit the number of its sample point, the depth
/// in scene units along the camera's axis, above 0, and the opacity in [0, 1], one for all,
/// one a hit, or of RGB maps (hits, 3). With media=True it may return (sample, depth, opacity,
/// back) as well: what reaches to a greater back is a slab of even density. It is called from
/// other threads, a tile at a time; an exception ends the bake and is raised here. An object
/// with a method through(view) is asked for such a function once the View is known: maps of
/// kinds fragments, layers and mtsm look from behind area lights.
///
/// light: a Light, of functions needed, else the scene's. progress: called with what is done
/// and of how much; a false answer that is not None ends the bake with Cancelled.
///
/// settings, as `dsm-tools bake` has them: kind ("deep"), resolution (a side or (width,
/// height)), samples, filter ("box", "tent", "gaussian"), filter_width, tolerance in [0, 1),
/// method ("greedy", "min-link"), side ("both", "lighter",
/// "darker"), layers, coverage (1, 2, 4, 8), resets, light_samples, views, preset ("nearest", "paper"), epsilon, accumulate,
/// levels ("mip", "y", "y:N"), max_level, channels ("auto", "mono", "rgb"; of functions mono
/// unless told), codec ("exact", "quantized"), depth_error, block ("zstd", "none"), tile,
/// mip, crop (x0, y0, x1, y1), seed, attrs (a dict).
///
/// The same arguments give the same bytes, whatever the number of threads. Raises
/// SettingError for settings that the kind does not have, SceneError, FileError, Cancelled.
#[pyfunction]
#[pyo3(signature = (source, output, *, light=None, media=false, threads=None, progress=None,
                    **settings))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments")]
pub(crate) fn bake<'py>(
    py: Python<'py>,
    source: &Bound<'py, PyAny>,
    output: PathBuf,
    light: Option<&Bound<'py, Light>>,
    media: bool,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
    settings: Option<&Bound<'py, PyDict>>,
) -> Result<Bound<'py, PyDict>> {
    let given = Options::new(py, settings)?;
    let (settings, is_sized) = bake_settings::take(&given)?;
    given.finish("bake")?;
    let job = Job { output, settings, is_sized, threads, progress: progress.as_ref() };
    if let Ok(map) = source.cast::<Map>() {
        return job.of_map(py, map.get().get());
    }
    if let Ok(scene) = source.cast::<Scene>() {
        return job.of_scene(py, scene.get(), light, "scene");
    }
    if let Ok(path) = source.extract::<PathBuf>() {
        let extension = path.extension().and_then(|end| end.to_str()).unwrap_or_default();
        return match extension.to_ascii_lowercase().as_str() {
            "dsm" => job.of_map(py, &py.detach(|| ShadowMap::open(&path))?),
            "exr" => job.of_image(py, &path),
            _ => {
                let scene = Scene::open(py, &path)?;
                job.of_scene(py, &scene, light, &path.to_string_lossy())
            }
        };
    }
    job.of_function(py, source, light, media)
}

/// One bake.
struct Job<'a> {
    output: PathBuf,
    settings: Bake,
    is_sized: bool,
    threads: Option<usize>,
    progress: Option<&'a Py<PyAny>>,
}

impl Job<'_> {
    fn of_scene<'py>(
        mut self,
        py: Python<'py>,
        scene: &Scene,
        light: Option<&Bound<'py, Light>>,
        name: &str,
    ) -> Result<Bound<'py, PyDict>> {
        let scene = scene.get();
        let light = light.map_or(scene.light, |light| *light.get().get());
        if !self.is_sized {
            self.settings.resolution = self.settings.kind.resolution_for(scene);
        }
        self.settings = bake_settings::describe(self.settings, name, scene.shutter);
        let report = run(py, self.threads, self.progress, |watch| {
            deepshadow::bake(scene, &light, &self.settings, &self.output, |at| watch.at(at))
        })?;
        described(py, &report, scene.warnings())
    }

    fn of_function<'py>(
        mut self,
        py: Python<'py>,
        source: &Bound<'py, PyAny>,
        light: Option<&Bound<'py, Light>>,
        has_media: bool,
    ) -> Result<Bound<'py, PyDict>> {
        let Some(light) = light else {
            return Err(Failure::setting("a function's hits need a light: light=Light(…)"));
        };
        if !source.is_callable() && !source.hasattr("through")? {
            let reason = "source: a scene, a file, a function, or an object with through(view)";
            return Err(Failure::setting(reason));
        }
        if !self.is_sized {
            self.settings.resolution = self.settings.kind.resolution().unwrap_or([1024; 2]);
        }
        let (function, light) = (source.clone().unbind(), light.get().get());
        let is_coloured = self.settings.channels == Channels::Rgb;
        let occluders = PythonOccluders::new(&function, light, is_coloured, has_media);
        let baked = run(py, self.threads, self.progress, |watch| {
            deepshadow::bake(&occluders, light, &self.settings, &self.output, |at| watch.at(at))
        });
        match (baked, occluders.take_raised()) {
            (Err(_), Some(raised)) => Err(raised.into()),
            (baked, _) => described(py, &baked?, &[]),
        }
    }

    fn of_map<'py>(mut self, py: Python<'py>, map: &ShadowMap) -> Result<Bound<'py, PyDict>> {
        if !self.settings.kind.is_made_of_maps() {
            let reason =
                "a map is baked to kind prefiltered alone: convert() makes other maps of it";
            return Err(Failure::setting(reason));
        }
        if self.is_sized || self.settings.channels != Channels::Auto {
            let reason = "resolution and channels are those of the map that it is made of";
            return Err(Failure::setting(reason));
        }
        self.settings.resolution = map.size();
        let report =
            run(py, self.threads, self.progress, |_| map.prefilter(&self.settings, &self.output))?;
        described(py, &report, &[])
    }

    fn of_image<'py>(self, py: Python<'py>, path: &Path) -> Result<Bound<'py, PyDict>> {
        let folder = tempfile::tempdir().map_err(PyErr::from)?;
        let map = folder.path().join("map.dsm");
        run(py, self.threads, None, |watch| -> Result<_, Error> {
            let mut image = MapSource::open(path, Selection::default(), &Limits::default())?;
            let options = ConvertOptions::default();
            let at = |at: Progress| watch.at(at);
            Ok(deepshadow::files::convert(&mut image, &map, &options, at)?)
        })?;
        let map = py.detach(|| ShadowMap::open(&map))?;
        self.of_map(py, &map)
    }
}

fn described<'py>(
    py: Python<'py>,
    report: &BakeReport,
    warnings: &[String],
) -> Result<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("samples", report.samples)?;
    dict.set_item("hits", report.hits)?;
    dict.set_item("cut_pixels", report.cut_pixels)?;
    dict.set_item("gained", report.gained)?;
    dict.set_item("tolerance", report.tolerance)?;
    dict.set_item("channels", report.channels)?;
    dict.set_item("bytes", report.bytes)?;
    dict.set_item("smaller_tiles", report.smaller_tiles)?;
    dict.set_item("warnings", warnings)?;
    Ok(dict)
}
