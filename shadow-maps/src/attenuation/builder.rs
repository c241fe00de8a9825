//! Attenuation maps from what points of a light see.

use std::ops::ControlFlow;

use dsm_core::detail::Result;
use dsm_core::{Error, HitSource, ShadowCamera, Transmittance};
use dsm_trace::detail::LightFrame;

use super::image::LayeredImage;
use super::view::{LightView, Seen, TILE};
use crate::prefilter::lists::FragmentLists;

/// The share of a place that a texel around it has where it counts there: a place in the
/// middle of a texel is in that alone, whichever way it is rounded.
const LEAST_SHARE: f64 = 1.0 / (1 << 20) as f64;

/// Puts what points of a light see together, as the light's centre has it (Agrawala et
/// al. 2000, §4, `Precompute`).
///
/// What a view passes to a hit, all or, behind what is not opaque, a part, counts in the
/// four texels around its place, in the layer that is nearest within a tolerance or a new
/// one, and at most once a layer. A layer's attenuation is its count over the number of
/// views whose raster holds it.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use dsm_core::{Error, Projection, RayHits, RaySource, SamplePoint, SurfaceHit, View};
/// use glam::DVec3;
/// use shadow_maps::detail::{AttenuationBuilder, AttenuationMap, AttenuationShadow};
///
/// let view = View { eye: DVec3::ZERO, target: DVec3::NEG_Z, up: DVec3::Y };
/// let view = view.raster(Projection::Perspective { fov: 90.0 }, [32, 32])?;
/// let mut builder = AttenuationBuilder::<f32>::new(view.shadow_camera(), [32, 32])?;
/// // A floor at depth 4, and a card at depth 2 that hides it from one of two points.
/// for (x, hidden) in [(-0.5, false), (0.5, true)] {
///     let source = RaySource(|_: SamplePoint, hits: &mut RayHits<f32>| -> Result<(), Error> {
///         let depth = if hidden { 2.0 } else { 4.0 };
///         hits.push_surface(SurfaceHit { depth, opacity: 1.0 })
///     });
///     let camera = view.at_eye(DVec3::X * x).shadow_camera();
///     builder.add_view(&source, camera, || ControlFlow::Continue(()))?;
/// }
/// let (lists, _) = builder.finish()?;
/// let shadow = AttenuationShadow::new(AttenuationMap::new(*builder.frame(), lists)?);
/// # use dsm_core::{AreaLight, LightVisibility};
/// let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X, DVec3::Y);
/// assert_eq!(shadow.visibility(DVec3::NEG_Z * 4.0, &light, 0), Ok(0.5));
/// // Nothing was seen at depth 8: it is dark.
/// assert_eq!(shadow.visibility(DVec3::NEG_Z * 8.0, &light, 0), Ok(0.0));
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct AttenuationBuilder<T: Transmittance> {
    camera: ShadowCamera,
    frame: LightFrame,
    tolerance: f64,
    image: LayeredImage<T>,
    views: Vec<LightView>,
    hits: u64,
    /// Layers after each view.
    layers: Vec<u64>,
}

/// What a map was made of.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AttenuationCounts {
    /// Surfaces that all rays met.
    pub hits: u64,
    /// Layers of all texels after each view.
    pub layers: Vec<u64>,
}

impl<T: Transmittance> AttenuationBuilder<T> {
    /// Layers of a texel are one if their depths differ by no more than so many sides of
    /// a texel there.
    pub const TOLERANCE: f64 = 1.0;

    /// The most views.
    pub const MAX_VIEWS: u32 = 1 << 16;

    /// For a map of `size` texels that `camera`'s NDC \[0, 1\]² covers; it stands in the
    /// light's centre.
    ///
    /// # Errors
    ///
    /// As [`LightFrame::new`]; [`Error::TooLarge`] past 2²⁸ texels.
    pub fn new(camera: ShadowCamera, size: [u32; 2]) -> Result<Self> {
        Self::with_tolerance(camera, size, Self::TOLERANCE)
    }

    /// The same with a tolerance of depths, in sides of a texel.
    ///
    /// # Errors
    ///
    /// As [`Self::new`]; [`Error::Setting`] for a tolerance that is negative or not
    /// finite.
    pub fn with_tolerance(camera: ShadowCamera, size: [u32; 2], tolerance: f64) -> Result<Self> {
        let frame = LightFrame::new(&camera, size, 0.0)?;
        let (count, limit) = (u64::from(size[0]) * u64::from(size[1]), 1 << 28);
        if count > limit {
            return Err(Error::TooLarge { what: "texels of an attenuation map", count, limit });
        }
        if !(0.0..f64::INFINITY).contains(&tolerance) {
            let reason = "it must be finite and not negative";
            return Err(Error::Setting { setting: "depth tolerance", reason });
        }
        let image = LayeredImage::new(size, tolerance * frame.footprint(1.0));
        let (views, layers) = (Vec::new(), Vec::new());
        Ok(Self { camera, frame, tolerance, image, views, hits: 0, layers })
    }

    /// The camera of the map.
    #[must_use]
    pub const fn camera(&self) -> &ShadowCamera {
        &self.camera
    }

    /// The frame of the map.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// The tolerance of depths, in sides of a texel.
    #[must_use]
    pub const fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Number of views so far.
    #[must_use]
    pub const fn views(&self) -> u32 {
        self.views.len() as u32
    }

    /// Adds what `source` shows through the middles of the pixels of a view of `camera`,
    /// which has as many as the map. `watch` is told of rows of tiles and may break it
    /// off: then the view counts in part. Hits are found in parallel and counted one by
    /// one, so that the map is the same on any number of threads. O(hits · layers of a
    /// texel).
    ///
    /// # Errors
    ///
    /// Those of the source and of its camera; [`Error::Setting`] if it shows media;
    /// [`Error::TooLarge`] past [`Self::MAX_VIEWS`] or 2³² − 1 layers.
    pub fn add_view<S: HitSource<T>>(
        &mut self,
        source: &S,
        camera: ShadowCamera,
        mut watch: impl FnMut() -> ControlFlow<()>,
    ) -> std::result::Result<ControlFlow<()>, S::Error> {
        let (number, limit) = (self.views(), u64::from(Self::MAX_VIEWS));
        if u64::from(number) >= limit {
            let count = u64::from(number) + 1;
            return Err(Error::TooLarge { what: "views", count, limit }.into());
        }
        let view = LightView::new(camera, (&self.camera, &self.frame))?;
        self.views.push(view);
        for top in (0..self.frame.size()[1]).step_by(TILE as usize) {
            if watch().is_break() {
                return Ok(ControlFlow::Break(()));
            }
            let (blocks, met) = view.row(source, &self.frame, top)?;
            self.hits += met;
            blocks.iter().flatten().try_for_each(|seen| self.splat(seen, number))?;
        }
        self.layers.push(self.image.len() as u64);
        Ok(ControlFlow::Continue(()))
    }

    /// Counts a place in the four texels whose middles are around it.
    fn splat(&mut self, seen: &Seen<T>, view: u32) -> Result<()> {
        let side = self.frame.footprint(1.0);
        let size = self.frame.size().map(f64::from);
        let lean = seen.lean(side);
        let first = seen.place.map(|at| (at - 0.5).floor());
        for (down, right) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)] {
            let texel = [first[0] + right, first[1] + down];
            let off = [0, 1].map(|axis| (texel[axis] + 0.5 - seen.place[axis]).abs());
            let is_inside = (0..2).all(|axis| (0.0..size[axis]).contains(&texel[axis]));
            if is_inside && (1.0 - off[0]) * (1.0 - off[1]) > LEAST_SHARE {
                let w = seen.w_at(texel, side);
                self.image.insert(texel.map(|at| at as u32), (w, lean), seen.passed, view)?;
            }
        }
        Ok(())
    }

    /// The layers of all texels, the nearest first: of each its w and the share of the
    /// light that it sees, in (0, 1]. O(layers · views).
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] without views, [`Error::TooLarge`] past 2³² − 1 layers.
    pub fn finish(&self) -> Result<(FragmentLists<T>, AttenuationCounts)> {
        if self.views.is_empty() {
            let reason = "there must be a view or more";
            return Err(Error::Setting { setting: "light samples", reason });
        }
        let mut lists = FragmentLists::new(self.frame.size());
        let [width, height] = self.frame.size();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let texel = y as usize * width as usize + x as usize;
            for layer in self.image.sorted(texel) {
                let place = [f64::from(x) + 0.5, f64::from(y) + 0.5, layer.w];
                let holding = self.views.iter().filter(|view| view.holds(place)).count();
                // Splats reach beyond the middles of texels.
                let views = f64::from((holding as u32).max(layer.views));
                let count = layer.count();
                // No more than 1: a view counts once a layer.
                let share = T::from_channels(|c| (count.as_ref()[c] / views) as f32);
                if share != T::BLOCKED {
                    lists.push(layer.w as f32, share);
                }
            }
            lists.finish_texel()?;
        }
        Ok((lists, AttenuationCounts { hits: self.hits, layers: self.layers.clone() }))
    }
}
