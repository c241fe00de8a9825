//! Occluders: the matter between a light and the world.

use std::fmt;

use dsm_core::{HitSource, Rgb, TileHits, TileSamples, Transmittance, ViewRaster};
use dsm_scene::{Scene, SceneRasterizer};

use crate::error::{Error, Result};

/// The interface renderers implement to have their scenes baked: hits through
/// whatever view a map is baked from.
///
/// A bake decides from where it looks: maps of area lights are seen from behind
/// the light, so that all that any point of it sees is in the map (Xie et al.
/// 2007, equation 4). [`Scene`]s are occluders, and [`ThroughView`] makes
/// occluders of a function from a view to a [`HitSource`].
///
/// ```
/// use deepshadow::visibility::{RaySource, RayHits, SamplePoint, SurfaceHit, ViewRaster};
/// use deepshadow::{AnyHitSource, Error, Occluders};
///
/// /// A pane of this opacity, 2 units from wherever it is seen.
/// struct Pane(f32);
///
/// impl Occluders for Pane {
///     fn mono(&self, _: &ViewRaster) -> Result<AnyHitSource<'_, f32>, Error> {
///         let hits = |_: SamplePoint, hits: &mut RayHits<f32>| {
///             hits.push_surface(SurfaceHit { depth: 2.0, opacity: self.0 })
///         };
///         Ok(AnyHitSource::new(RaySource(hits)))
///     }
///
///     fn rgb(
///         &self,
///         _: &ViewRaster,
///     ) -> Result<AnyHitSource<'_, deepshadow::visibility::Rgb>, Error> {
///         Err(Error::Unsupported("a pane has no colours".to_owned()))
///     }
/// }
/// assert!(!Pane(0.5).is_coloured());
/// ```
pub trait Occluders: Sync {
    /// Whether any opacity differs between channels, so that a map with one
    /// channel would lose something.
    fn is_coloured(&self) -> bool {
        false
    }

    /// The width of the finest thing in scene units, of which a map with rounded depths
    /// is to tell the front from the back, such as a hair's; `None` if there is none.
    fn finest_width(&self) -> Option<f64> {
        None
    }

    /// The hits through a view, with one opacity each.
    ///
    /// # Errors
    ///
    /// Whatever keeps the occluders from being seen.
    fn mono(&self, view: &ViewRaster) -> Result<AnyHitSource<'_, f32>>;

    /// The hits through a view, with three opacities each.
    ///
    /// # Errors
    ///
    /// As [`Self::mono`]; [`Error::Unsupported`] for occluders without colours.
    fn rgb(&self, view: &ViewRaster) -> Result<AnyHitSource<'_, Rgb>>;
}

/// A hit source without its type, called once a tile.
///
/// ```
/// use deepshadow::AnyHitSource;
/// use deepshadow::visibility::{RayHits, RaySource, SamplePoint, SurfaceHit};
///
/// let pane = RaySource(|_: SamplePoint, hits: &mut RayHits<f32>| {
///     hits.push_surface(SurfaceHit { depth: 2.0, opacity: 0.5 })
/// });
/// let source: AnyHitSource<'_, f32> = AnyHitSource::new(pane);
/// # drop(source);
/// ```
pub struct AnyHitSource<'a, T>(Box<dyn HitSource<T, Error = SourceError> + 'a>);

impl<'a, T: Transmittance> AnyHitSource<'a, T> {
    /// Wraps a source.
    #[must_use]
    pub fn new<S>(source: S) -> Self
    where
        S: HitSource<T> + 'a,
        S::Error: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        Self(Box::new(Wrapped(source)))
    }
}

impl<T> fmt::Debug for AnyHitSource<'_, T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("AnyHitSource")
    }
}

impl<T: Transmittance> HitSource<T> for AnyHitSource<'_, T> {
    type Error = SourceError;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), SourceError> {
        self.0.hits(samples, hits)
    }

    fn has_media(&self) -> bool {
        self.0.has_media()
    }
}

/// The error of a source of any type.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct SourceError(Box<dyn std::error::Error + Send + Sync>);

impl From<dsm_core::Error> for SourceError {
    fn from(error: dsm_core::Error) -> Self {
        Self(Box::new(error))
    }
}

struct Wrapped<S>(S);

impl<T, S> HitSource<T> for Wrapped<S>
where
    T: Transmittance,
    S: HitSource<T>,
    S::Error: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    type Error = SourceError;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), SourceError> {
        self.0.hits(samples, hits).map_err(|error| SourceError(error.into()))
    }

    fn has_media(&self) -> bool {
        self.0.has_media()
    }
}

/// Occluders by a function from a view to the hits through it, with one opacity
/// each.
///
/// ```
/// use deepshadow::visibility::{LightExtent, Projection, View, ViewRaster};
/// use deepshadow::scene::Light;
/// use deepshadow::glam::DVec3;
/// use deepshadow::{Bake, ThroughView, bake};
/// use dsm_core::{Error, RayHits, RaySource, SamplePoint, SurfaceHit};
///
/// // An opaque sphere of radius 1 at the origin.
/// let sphere = ThroughView(|view: &ViewRaster| {
///     let view = *view;
///     Ok(RaySource(move |at: SamplePoint, hits: &mut RayHits<f32>| -> Result<(), Error> {
///         let ray = view.ray(at.x, at.y, 0.0);
///         let (start, along) = (ray.at(0.0), ray.at(1.0) - ray.at(0.0));
///         let (a, b) = (along.length_squared(), start.dot(along));
///         let inner = b * b - a * (start.length_squared() - 1.0);
///         if inner > 0.0 {
///             let depth = ((-b - inner.sqrt()) / a) as f32;
///             hits.push_surface(SurfaceHit { depth, opacity: 1.0 })?;
///         }
///         Ok(())
///     }))
/// });
/// let view = View { eye: DVec3::Y * 4.0, target: DVec3::ZERO, up: DVec3::Z };
/// let projection = Projection::Perspective { fov: 45.0 };
/// let light = Light { view, projection, extent: LightExtent::POINT };
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("sphere.dsm");
/// let report = bake(&sphere, &light, &Bake::new([32, 32])?, &path, |_| {
///     std::ops::ControlFlow::Continue(())
/// })?;
/// assert!(report.hits > 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ThroughView<F>(pub F);

impl<F, S> Occluders for ThroughView<F>
where
    F: Fn(&ViewRaster) -> Result<S> + Sync,
    S: HitSource<f32> + 'static,
    S::Error: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    fn mono(&self, view: &ViewRaster) -> Result<AnyHitSource<'_, f32>> {
        (self.0)(view).map(AnyHitSource::new)
    }

    fn rgb(&self, _: &ViewRaster) -> Result<AnyHitSource<'_, Rgb>> {
        Err(Error::Unsupported("these occluders have no colours: bake one channel".to_owned()))
    }
}

impl Occluders for Scene {
    fn is_coloured(&self) -> bool {
        self.is_coloured()
    }

    fn finest_width(&self) -> Option<f64> {
        self.finest_strand()
    }

    fn mono(&self, view: &ViewRaster) -> Result<AnyHitSource<'_, f32>> {
        Ok(AnyHitSource::new(SceneRasterizer::<f32>::new(self, *view)?))
    }

    fn rgb(&self, view: &ViewRaster) -> Result<AnyHitSource<'_, Rgb>> {
        Ok(AnyHitSource::new(SceneRasterizer::<Rgb>::new(self, *view)?))
    }
}
