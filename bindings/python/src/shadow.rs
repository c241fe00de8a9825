//! Shadows, ready for points.

use std::time::{Duration, Instant};

use deepshadow::glam::DVec3;
use deepshadow::visibility::detail::random::scattered_seed;
use deepshadow::visibility::{Facing, ShadedPoint};
use deepshadow::{Shadow as FrontShadow, Values};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::error::{Failure, Result};
use crate::points::Points;
use crate::threads;

/// The shadows of one light by one method: what a method builds for itself is built once.
///
/// Map.shadow() and Scene.shadow() make one. Any number of threads may use it.
#[pyclass(frozen, module = "deepshadow")]
pub(crate) struct Shadow {
    shadow: FrontShadow,
    seed: u64,
    /// Why points of the world cannot be answered.
    no_world: Option<String>,
}

/// Points that are answered first between two looks for Ctrl-C, and at most.
const FEW: usize = 2 * TASK;
const MANY: usize = 1 << 20;

/// Points that one task takes.
const TASK: usize = 1 << 10;

/// The time that Ctrl-C may be waited for, roughly.
const SOON: Duration = Duration::from_millis(25);

/// Points in the space that they are given in.
enum Asked {
    World(Points),
    Raster(Points),
    /// With what they lie on: normals of surfaces, or directions of strands.
    Shaded(Points, Points, fn(DVec3) -> Facing),
}

impl Asked {
    fn new(
        points: &Bound<'_, PyAny>,
        space: &str,
        normals: Option<&Bound<'_, PyAny>>,
        tangents: Option<&Bound<'_, PyAny>>,
    ) -> Result<Self> {
        let points = Points::new(points, "points")?;
        let (facing, kind): (_, fn(DVec3) -> Facing) = match (normals, tangents) {
            (Some(_), Some(_)) => return Err(Failure::setting("normals or tangents, not both")),
            (Some(normals), None) => (Points::new(normals, "normals")?, Facing::Surface),
            (None, Some(tangents)) => (Points::new(tangents, "tangents")?, Facing::Strand),
            (None, None) => {
                return match space {
                    "world" => Ok(Self::World(points)),
                    "raster" => Ok(Self::Raster(points)),
                    other => {
                        let reason = format!("space: '{other}' is none of world, raster");
                        Err(Failure::setting(reason))
                    }
                };
            }
        };
        if space != "world" {
            return Err(Failure::setting("normals and tangents are for points of the world"));
        }
        if facing.all().len() != points.all().len() {
            return Err(Failure::setting("as many normals or tangents as points are needed"));
        }
        Ok(Self::Shaded(points, facing, kind))
    }

    fn points(&self) -> &Points {
        match self {
            Self::World(points) | Self::Raster(points) | Self::Shaded(points, ..) => points,
        }
    }
}

impl Shadow {
    pub(crate) const fn new(shadow: FrontShadow, seed: u64, no_world: Option<String>) -> Self {
        Self { shadow, seed, no_world }
    }

    /// The answers of some of the points, on the current pool.
    fn answer(&self, asked: &Asked, first: usize, end: usize) -> Result<Values> {
        let points = &asked.points().all()[first..end];
        Ok(match asked {
            Asked::World(_) => {
                let points: Vec<_> = points.iter().copied().map(DVec3::from).collect();
                self.shadow.query_from(&points, first as u64)?
            }
            Asked::Raster(_) => self.shadow.query_raster(points, first as u64)?,
            Asked::Shaded(_, facing, kind) => {
                let seed = scattered_seed(self.seed).wrapping_add(first as u64);
                let shaded = (0..).zip(points).zip(&facing.all()[first..end]);
                let shaded: Vec<_> = shaded
                    .map(|((number, &position), &facing)| ShadedPoint {
                        position: position.into(),
                        facing: kind(facing.into()),
                        seed: seed.wrapping_add(number),
                    })
                    .collect();
                let parts = shaded.par_chunks(TASK).map(|part| self.shadow.query_shaded(part));
                let parts = parts.collect::<std::result::Result<Vec<_>, _>>()?;
                let mut numbers = Vec::new();
                parts.into_iter().for_each(|part| append(&mut numbers, part));
                if self.shadow.channels() == 1 {
                    Values::Mono(numbers)
                } else {
                    Values::Rgb(numbers.as_chunks::<3>().0.to_vec())
                }
            }
        })
    }

    /// The shadow factors of points.
    pub(crate) fn query<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        space: &str,
        [normals, tangents]: [Option<&Bound<'py, PyAny>>; 2],
        threads: Option<usize>,
    ) -> Result<Bound<'py, PyAny>> {
        let asked = Asked::new(points, space, normals, tangents)?;
        if let (Some(reason), false) = (&self.no_world, matches!(asked, Asked::Raster(_))) {
            return Err(Failure::setting(reason.clone()));
        }
        let pool = threads::pool(threads)?;
        let (count, channels) = (asked.points().all().len(), self.shadow.channels());
        let mut numbers: Vec<f32> = Vec::with_capacity(count * channels);
        let (mut first, mut step) = (0, FEW);
        while first < count {
            let end = count.min(first + step);
            let started = Instant::now();
            let answer = || pool.install(|| self.answer(&asked, first, end));
            let values = py.detach(answer)?;
            append(&mut numbers, values);
            py.check_signals()?;
            first = end;
            if started.elapsed() < SOON {
                step = (2 * step).min(MANY);
            }
        }
        let mut shape = asked.points().shape().to_vec();
        if channels > 1 {
            shape.push(channels);
        }
        Ok(PyArray1::from_vec(py, numbers).reshape(shape)?.into_any())
    }
}

/// Appends the numbers of values.
fn append(numbers: &mut Vec<f32>, values: Values) {
    match values {
        Values::Mono(values) => numbers.extend(values),
        Values::Rgb(values) => numbers.extend(values.as_flattened()),
        other => (0..other.len()).for_each(|point| {
            numbers.extend(&other.rgb(point)[..other.channels()]);
        }),
    }
}

#[pymethods]
impl Shadow {
    /// Numbers a point: 1 or 3.
    #[getter]
    fn channels(&self) -> usize {
        self.shadow.channels()
    }

    /// at(points, *, space="world", normals=None, tangents=None, threads=None)
    /// --
    ///
    /// The shadow factors of points: 1 is lit, 0 is dark; float32.
    ///
    /// points: shape (…, 3), float64; in the world, or with space="raster" column and row in
    /// pixels of level 0 and the depth in scene units. normals or tangents, of the same
    /// shape: what points of the world lie on, surfaces or strands, which tells each a depth
    /// bias of its own where the method has such. The answer has the shape (…), of RGB maps
    /// (…, 3). What lies outside the map, behind its camera or at NaN is lit. threads: as
    /// many as there are cores unless told.
    ///
    /// Raises SettingError for arrays of other shapes, FileError for damaged tiles.
    #[pyo3(signature = (points, *, space="world", normals=None, tangents=None, threads=None))]
    fn at<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        space: &str,
        normals: Option<&Bound<'py, PyAny>>,
        tangents: Option<&Bound<'py, PyAny>>,
        threads: Option<usize>,
    ) -> Result<Bound<'py, PyAny>> {
        self.query(py, points, space, [normals, tangents], threads)
    }
}
