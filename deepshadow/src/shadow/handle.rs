//! Shadows, ready for queries.

use std::sync::Arc;

use dsm_core::detail::random::scattered_seed;
use dsm_core::{AreaLight, Facing, LightVisibility, Rgb, ShadedPoint};
use glam::DVec3;
use rayon::prelude::*;

use super::any_visibility::{AnyVisibility, Foreign};
use super::statistics::ShadowStatistics;
use crate::error::{Error, Result};
use crate::values::Values;

/// Points that one task takes.
const TASK: usize = 1 << 10;

/// The shadows of one light by one method, ready for queries of any number of
/// points from any number of threads. Clones are the same shadows.
///
/// [`ShadowMap::shadow`](crate::ShadowMap::shadow) makes one of a map: whatever
/// the method builds for itself is then built once. [`Self::of`] wraps any other
/// [`LightVisibility`].
///
/// ```no_run
/// use deepshadow::{Query, ShadowMap, TraceMethod};
/// use glam::DVec3;
///
/// let map = ShadowMap::open("fur.dsm")?;
/// let shadow = map.shadow(&Query::new().with_method(TraceMethod::new(64)))?;
/// let factors = shadow.query(&[DVec3::new(0.0, 1.0, 0.5), DVec3::new(0.1, 1.0, 0.5)])?;
/// assert_eq!(factors.len(), 2);
/// # Ok::<(), deepshadow::Error>(())
/// ```
#[derive(Clone)]
pub struct Shadow {
    visibility: Arc<dyn AnyVisibility>,
    light: AreaLight,
    seed: u64,
}

impl Shadow {
    /// The shadows of `light` that `visibility` computes, for points of the world.
    #[must_use]
    pub fn of<V>(visibility: V, light: AreaLight) -> Self
    where
        V: LightVisibility + Send + Sync + 'static,
        V::Error: std::error::Error + Send + Sync + 'static,
    {
        Self { visibility: Arc::new(Foreign(visibility)), light, seed: 0 }
    }

    pub(crate) fn new(visibility: Box<dyn AnyVisibility>, light: AreaLight, seed: u64) -> Self {
        Self { visibility: visibility.into(), light, seed: scattered_seed(seed) }
    }

    /// Numbers a point: 1 or 3.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.visibility.channels()
    }

    /// The light that casts them.
    #[must_use]
    pub const fn light(&self) -> &AreaLight {
        &self.light
    }

    /// The shadow factors of points of the world, on the threads of the current
    /// pool. Points outside the map, behind its camera or at NaN are lit: 1.
    ///
    /// # Errors
    ///
    /// What reading the map's tiles says.
    pub fn query(&self, points: &[DVec3]) -> Result<Values> {
        self.query_from(points, 0)
    }

    /// [`Self::query`] of points that are part of a longer list, from its point
    /// number `first` on: the answers are those of the whole list.
    ///
    /// # Errors
    ///
    /// As [`Self::query`].
    pub fn query_from(&self, points: &[DVec3], first: u64) -> Result<Values> {
        self.in_tasks(points, first, |points, seed, values| {
            let shaded = |(number, &position): (u64, &DVec3)| {
                let seed = seed.wrapping_add(number);
                ShadedPoint { position, facing: Facing::Light, seed }
            };
            let points: Vec<_> = (0..).zip(points).map(shaded).collect();
            self.visibility.world(&points, &self.light, values)
        })
    }

    /// The shadow factors of points given by their raster position, in pixels of
    /// level 0, and their depth; `first` as for [`Self::query_from`].
    ///
    /// # Errors
    ///
    /// As [`Self::query`]; [`Error::Unsupported`] for shadows without a map.
    pub fn query_raster(&self, points: &[[f64; 3]], first: u64) -> Result<Values> {
        self.in_tasks(points, first, |points, seed, values| {
            self.visibility.raster(points, seed, &self.light, values)
        })
    }

    /// The shadow factors of points with what they lie on, which tells a depth
    /// bias of its own for each. On the calling thread.
    ///
    /// # Errors
    ///
    /// As [`Self::query`].
    pub fn query_shaded(&self, points: &[ShadedPoint]) -> Result<Values> {
        let mut values = Values::of(self.channels());
        self.visibility.world(points, &self.light, &mut values)?;
        Ok(values)
    }

    /// The work that was done so far.
    #[must_use]
    pub fn statistics(&self) -> ShadowStatistics {
        self.visibility.statistics()
    }

    /// Queries some points at a time, in parallel, each task with its first seed.
    fn in_tasks<P: Sync>(
        &self,
        points: &[P],
        first: u64,
        ask: impl Fn(&[P], u64, &mut Values) -> Result<()> + Sync,
    ) -> Result<Values> {
        let tasks = points.par_chunks(TASK).enumerate().map(|(task, points)| {
            let number = first.wrapping_add((task * TASK) as u64);
            let mut values = Values::of(self.channels());
            ask(points, self.seed.wrapping_add(number), &mut values).map(|()| values)
        });
        let parts = tasks.collect::<Result<Vec<_>>>()?;
        let mut values = Values::of(self.channels());
        parts.iter().for_each(|part| values.append(part));
        Ok(values)
    }
}

/// Shadows of any map, as renderers query them; mono ones have three equal
/// channels.
impl LightVisibility for Shadow {
    type Value = Rgb;
    type Error = Error;

    fn visibility(&self, receiver: DVec3, light: &AreaLight, seed: u64) -> Result<Rgb> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        let mut values = Vec::with_capacity(1);
        self.visibilities(&[point], light, &mut values)?;
        Ok(values.pop().unwrap_or(Rgb::new(1.0, 1.0, 1.0)))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<Rgb>,
    ) -> Result<()> {
        let mut own = Values::of(self.channels());
        self.visibility.world(points, light, &mut own)?;
        values.extend((0..own.len()).map(|point| {
            let [red, green, blue] = own.rgb(point);
            Rgb::new(red, green, blue)
        }));
        Ok(())
    }
}

impl std::fmt::Debug for Shadow {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { light, seed, .. } = self;
        let mut all = formatter.debug_struct("Shadow");
        all.field("channels", &self.channels()).field("light", light).field("seed", seed);
        all.finish_non_exhaustive()
    }
}
