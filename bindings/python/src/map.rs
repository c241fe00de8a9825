//! Open maps.

use std::path::PathBuf;

use deepshadow::files::detail::{AnyDeepMap, TileRect};
use deepshadow::{OpenOptions, ShadowMap};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{LevelColumns, slice, vertices};
use crate::error::{Failure, Result, whole_message};
use crate::level::Level;
use crate::options::Options;
use crate::query::Asked;
use crate::scene::Scene;
use crate::shadow::Shadow;
use crate::tile_cache::TileCache;
use crate::{arrays, attributes, camera, threads, values};

/// A shadow map in a file, of any kind. deepshadow.open() makes one. Any number of threads
/// may use it; tiles are read when they are needed.
#[pyclass(frozen, module = "deepshadow")]
pub(crate) struct Map {
    map: ShadowMap,
    path: PathBuf,
}

/// open(path, *, cache=None)
/// --
///
/// Opens a map (.dsm) of any kind. cache: a TileCache that maps share; else it has one of
/// its own, of at most 1 GiB. Cost: a few reads, whatever its size. path may be an address in
/// an object store ("s3://maps/key.dsm"), as a str, if the package was built with the feature
/// remote.
///
/// Raises FileError with the file and the place in it.
#[pyfunction]
#[pyo3(signature = (path, *, cache=None))]
pub(crate) fn open(
    py: Python<'_>,
    path: PathBuf,
    cache: Option<&Bound<'_, TileCache>>,
) -> Result<Map> {
    let options = cache.map_or_else(OpenOptions::new, |cache| cache.get().options().clone());
    let map = py.detach(|| options.open(&path))?;
    Ok(Map { map, path })
}

impl Map {
    /// The map of the front door.
    pub(crate) const fn get(&self) -> &ShadowMap {
        &self.map
    }

    /// The functions of a rectangle of a level, or else why there are none.
    fn functions(&self, level: u32, pixels: Option<TileRect>) -> Result<AnyDeepMap> {
        let Some(found) = self.map.levels().get(level as usize) else {
            let count = self.map.levels().len();
            let reason = format!("level {level}: the map has {count}, counted from 0");
            return Err(PyIndexError::new_err(reason).into());
        };
        let (width, height) = (found.width, found.height);
        let pixels = pixels.unwrap_or(TileRect { x: 0, y: 0, width, height });
        self.map.functions(level, pixels)?.ok_or_else(|| {
            let reason = format!(
                "a map of kind {} has no visibility functions: contents() tells what it holds",
                self.map.kind()
            );
            deepshadow::Error::Query { path: self.path.clone(), reason }.into()
        })
    }

    fn shadow_of<'py>(&self, py: Python<'py>, asked: &Asked<'py>) -> Result<Shadow> {
        let query = asked.query(self.map.default_method())?;
        let pool = threads::pool(None)?;
        let shadow = match &asked.near {
            None => py.detach(|| pool.install(|| self.map.shadow(&query)))?,
            Some(near) => {
                if let Ok(scene) = near.cast::<Scene>() {
                    let traced = scene.get().traced(py)?;
                    py.detach(|| pool.install(|| self.map.hybrid_shadow(traced, &query)))?
                } else {
                    let near = near.cast::<Self>().map_err(PyErr::from)?.get();
                    py.detach(|| {
                        pool.install(|| self.map.hybrid_shadow_of_maps(&near.map, &query))
                    })?
                }
            }
        };
        let no_world = self.map.info().camera.is_none().then(|| {
            let path = self.path.display();
            format!("{path}: the map has no camera to project points of the world with")
        });
        Ok(Shadow::new(shadow, query.seed, no_world))
    }
}

/// A row or a column, counted from the end if it is negative.
fn index(at: i64, count: u32) -> Option<u32> {
    let at = if at < 0 { at + i64::from(count) } else { at };
    u32::try_from(at).ok().filter(|&at| at < count)
}

#[pymethods]
impl Map {
    /// The file.
    #[getter]
    fn path(&self) -> &PathBuf {
        &self.path
    }

    /// The name of the map's kind, one of deepshadow.KINDS.
    #[getter]
    fn kind(&self) -> &'static str {
        self.map.kind()
    }

    /// Rows and columns of level 0, in pixels.
    #[getter]
    fn shape(&self) -> (u32, u32) {
        let [width, height] = self.map.size();
        (height, width)
    }

    /// Numbers a value: 1 or 3.
    #[getter]
    fn channels(&self) -> usize {
        self.map.channels()
    }

    /// The levels, finest first.
    #[getter]
    fn levels(&self) -> Vec<Level> {
        self.map.levels().iter().map(Level::from).collect()
    }

    /// Free attributes of the header: strings, numbers, lists of numbers, bytes.
    #[getter]
    fn attrs<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>> {
        let all = self.map.metadata().attributes.iter();
        attributes::to_dict(py, all.map(|(name, value)| (name.as_str(), value.clone())))
    }

    /// The camera's matrices world_to_camera and world_to_ndc, (4, 4) for column vectors,
    /// None for one that is unknown; None of a map without a camera. The camera looks down
    /// −z; NDC are [0, 1]² with y down.
    #[getter]
    fn camera<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyDict>>> {
        self.map.info().camera.map(|known| camera::to_dict(py, known)).transpose()
    }

    /// The light's shape and full width and height in scene units; None if unknown.
    #[getter]
    fn light(&self) -> Option<(&'static str, [f64; 2])> {
        self.map.info().light.map(|light| (light.shape().name(), light.size()))
    }

    /// Everything that the header says, and the keys of this kind alone.
    #[getter]
    fn metadata(&self, py: Python<'_>) -> Result<Py<PyAny>> {
        let mut all = serde_json::to_value(self.map.info()).unwrap_or_default();
        let own = self.map.kind_metadata()?;
        if let (Some(all), serde_json::Value::Object(own)) = (all.as_object_mut(), own) {
            all.extend(own);
            all.insert("software".to_owned(), self.map.metadata().software.clone().into());
        }
        values::plain(py, &all)
    }

    /// The name of the method of queries that name none.
    #[getter]
    fn default_method(&self) -> &'static str {
        self.map.default_method().name()
    }

    /// columns(level=0)
    /// --
    ///
    /// The visibility functions of a level as read-only columns (offsets, z, v): the vertices
    /// of pixel i, counted row by row, are offsets[i] to offsets[i + 1]. offsets: (pixels + 1,)
    /// uint32; z: (vertices,) float32, depths in scene units, ascending; v: (vertices,)
    /// float32 in [0, 1], of RGB maps (vertices, 3). Nothing is copied for mono maps, and
    /// the arrays outlive the map. Cost: O(vertices).
    ///
    /// Raises QueryError for kinds without visibility functions, FileError for damaged tiles.
    #[pyo3(signature = (level=0))]
    fn columns<'py>(
        &self,
        py: Python<'py>,
        level: u32,
    ) -> Result<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let columns = py.detach(|| self.functions(level, None).map(LevelColumns::new))?;
        let [offsets, depths, values] = columns.arrays(py)?;
        Ok((offsets, depths, values))
    }

    /// to_awkward(level=0)
    /// --
    ///
    /// The same as an Awkward Array of type rows * columns * var * {"z": float32, "v": float32},
    /// without a copy. Needs the package awkward.
    #[pyo3(signature = (level=0))]
    fn to_awkward<'py>(&self, py: Python<'py>, level: u32) -> Result<Bound<'py, PyAny>> {
        let (offsets, depths, values) = self.columns(py, level)?;
        let fields = PyDict::new(py);
        fields.set_item("z", depths)?;
        fields.set_item("v", values)?;
        // The columns were read: there is such a level.
        let shape = self.map.levels().get(level as usize).map(|level| (level.height, level.width));
        Ok(py.import("deepshadow._awkward")?.call_method1("image", (shape, offsets, fields))?)
    }

    /// map[y, x]: the vertices of a pixel of level 0, (n, 2) float32 of a depth and a value,
    /// of RGB maps (n, 4). Cost: one tile.
    fn __getitem__<'py>(&self, py: Python<'py>, at: (i64, i64)) -> Result<Bound<'py, PyAny>> {
        let [width, height] = self.map.size();
        let (Some(y), Some(x)) = (index(at.0, height), index(at.1, width)) else {
            let reason = format!("pixel ({}, {}) is outside the map", at.0, at.1);
            return Err(PyIndexError::new_err(reason).into());
        };
        let pixel = TileRect { x, y, width: 1, height: 1 };
        vertices(py, py.detach(|| self.functions(0, Some(pixel)))?)
    }

    /// contents(y, x, level=0)
    /// --
    ///
    /// The numbers that are stored of a pixel, of any kind: a dict of their name, the names
    /// of their columns, and rows of them.
    #[pyo3(signature = (y, x, level=0))]
    fn contents<'py>(
        &self,
        py: Python<'py>,
        y: u32,
        x: u32,
        level: u32,
    ) -> Result<Bound<'py, PyDict>> {
        let contents = py.detach(|| self.map.contents(level, [x, y]))?;
        let dict = PyDict::new(py);
        dict.set_item("name", contents.name())?;
        dict.set_item("columns", contents.columns())?;
        dict.set_item("rows", values::plain(py, &contents)?)?;
        Ok(dict)
    }

    /// slice(z, level=0, *, threads=None)
    /// --
    ///
    /// The transmittance of every pixel at a depth in scene units: (rows, columns) float32,
    /// of RGB maps (rows, columns, 3). Cost: O(vertices).
    ///
    /// Raises QueryError for kinds without visibility functions.
    #[pyo3(signature = (z, level=0, *, threads=None))]
    fn slice<'py>(
        &self,
        py: Python<'py>,
        z: f32,
        level: u32,
        threads: Option<usize>,
    ) -> Result<Bound<'py, PyAny>> {
        if z.is_nan() {
            return Err(Failure::setting("z: a depth must be a number"));
        }
        let pool = threads::pool(threads)?;
        let (numbers, channels) = py.detach(|| -> Result<_> {
            let map = self.functions(level, None)?;
            Ok(pool.install(|| slice(&map, z)))
        })?;
        let Some(level) = self.map.levels().get(level as usize) else {
            return Ok(py.None().into_bound(py));
        };
        let shape = [level.height as usize, level.width as usize];
        arrays::picture(py, numbers, shape, channels)
    }

    /// shadow(**query)
    /// --
    ///
    /// The shadows of a query, ready for any number of points: for maps of kind fragments
    /// this builds the tracer, O(fragments). query: as for at().
    #[pyo3(signature = (**query))]
    fn shadow<'py>(&self, py: Python<'py>, query: Option<&Bound<'py, PyDict>>) -> Result<Shadow> {
        let given = Options::new(py, query)?;
        let asked = Asked::take(&given)?;
        given.finish("shadow")?;
        self.shadow_of(py, &asked)
    }

    /// at(points, *, space="world", normals=None, tangents=None, threads=None, **query)
    /// --
    ///
    /// The shadow factors of points: 1 is lit, 0 is dark; float32. points, space, normals,
    /// tangents and threads: as Shadow.at() has them.
    ///
    /// query, with the names and defaults of `dsm-tools lookup`: method ("filter", "trace",
    /// "pcf", "prefilter", "hybrid"; default: the map's own), filter ("point", "box", "tent",
    /// "gaussian"), width in pixels of level 0, level (a number or "auto"), bias in scene
    /// units (or "auto" of method filter; of trace the ray offset), rays (256; hybrid: 16),
    /// light (a Light) or light_size (width, height), rule ("ratio", "subtract"), z_threshold,
    /// far_table ("auto", "on", "off"), accumulate ("add", "multiply", "max"), splits, reach,
    /// near (a Map of kind fragments or a Scene, of hybrid), seed.
    ///
    /// Raises SettingError for what the method does not have, QueryError for what the map
    /// cannot answer, FileError for damaged tiles.
    #[pyo3(signature = (points, *, space="world", normals=None, tangents=None, threads=None, **query))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments")]
    fn at<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        space: &str,
        normals: Option<&Bound<'py, PyAny>>,
        tangents: Option<&Bound<'py, PyAny>>,
        threads: Option<usize>,
        query: Option<&Bound<'py, PyDict>>,
    ) -> Result<Bound<'py, PyAny>> {
        let given = Options::new(py, query)?;
        let asked = Asked::take(&given)?;
        given.finish("at")?;
        let shadow = self.shadow_of(py, &asked)?;
        shadow.query(py, points, space, [normals, tangents], threads)
    }

    /// Everything that is wrong with the file, a line each; empty if it is sound.
    /// Cost: O(vertices).
    fn verify(&self, py: Python<'_>) -> Vec<String> {
        let errors = py.detach(|| self.map.verify());
        errors.iter().map(|error| whole_message(error)).collect()
    }

    /// Counts of what the tiles hold together. Cost: O(vertices).
    fn summary(&self, py: Python<'_>) -> Result<Py<PyAny>> {
        let summary = py.detach(|| self.map.summary())?;
        values::plain(py, &summary)
    }

    /// What each level states of its errors: a dict of tolerance, max, mean, depth and
    /// at_depth, finest first.
    fn stated_errors<'py>(&self, py: Python<'py>) -> Result<Vec<Bound<'py, PyDict>>> {
        let pool = threads::pool(None)?;
        let stated = py.detach(|| pool.install(|| self.map.stated_errors()))?;
        let dicts = stated.iter().map(|stated| {
            let dict = PyDict::new(py);
            for (name, value) in [
                ("tolerance", stated.tolerance),
                ("max", stated.max),
                ("mean", stated.mean),
                ("depth", stated.depth),
                ("at_depth", stated.at_depth),
            ] {
                dict.set_item(name, value)?;
            }
            Ok(dict)
        });
        dicts.collect()
    }

    /// A map is opened again where it is unpickled.
    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (&PathBuf,))> {
        Ok((py.import("deepshadow")?.getattr("open")?, (&self.path,)))
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.map.size();
        let (kind, channels) = (self.map.kind(), self.map.channels());
        format!(
            "<deepshadow.Map {kind}, {height} x {width}, {channels} channel(s): {}>",
            self.path.display()
        )
    }
}
