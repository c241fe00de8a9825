//! Soft shadows by percentage closer filtering: what traced ones are compared
//! with (Xie, Tabellion & Pearce 2007, §3).

use std::sync::Arc;

use dsm_core::{AreaLight, Error, LightVisibility, Transmittance};
use dsm_trace::detail::{LightFrame, LightMean, TraceCounters, TraceStatistics};
use glam::DVec3;

use crate::layers_of_pixel::PixelLayers;
use crate::traced_map::sealed::PixelReader;
use crate::traced_map::{TracedMap, map_frame};

/// The layers of a pixel that shade.
///
/// ```
/// use mtsm::detail::FilteredLayers;
///
/// assert_ne!(FilteredLayers::All, FilteredLayers::Shallowest);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum FilteredLayers {
    /// The first only, as in a plain shadow map.
    Shallowest,
    /// All that a deep shadow map has: of a multilayer transparent shadow map the
    /// first run.
    #[default]
    All,
}

/// Soft shadows by stochastic taps in a filter region around the receiver's
/// place in a map of layers. The region is what the light's outline becomes on
/// the plane of the map's smallest depth, seen from the receiver: for a light of
/// radius r and a camera at its centre, r · resolution · (1/z_min − 1/z) pixels
/// around it (equation 1). Every tap compares depths at the receiver's own, so
/// that shadows merge and shift as the paper shows (§3): a baseline.
///
/// Taps are those points of the region that the shadow rays of a tracer with as
/// many rays would go through, so that noise cancels where both are compared.
/// Receivers beside the light are lit, and taps outside the map.
#[derive(Debug)]
pub struct SoftPercentageCloser<M> {
    map: Arc<M>,
    frame: LightFrame,
    /// The largest w of all layers.
    nearest: Option<f64>,
    layers: FilteredLayers,
    taps: u32,
    /// None: the side of a pixel at the receiver's depth.
    bias: Option<f64>,
    counters: TraceCounters,
}

impl<M: TracedMap> SoftPercentageCloser<M> {
    /// A filter of 256 taps over `map`, without bias. O(pixels).
    ///
    /// # Errors
    ///
    /// [`Error::Camera`] if the map has no perspective camera; what is wrong with a
    /// tile of a file.
    pub fn new(map: Arc<M>, layers: FilteredLayers) -> Result<Self, M::BuildError> {
        let frame = map_frame(&*map)?;
        let mut nearest = f32::INFINITY;
        map.depth_ranges(|_, [near, _]| nearest = nearest.min(near))?;
        let nearest = (nearest < f32::INFINITY).then(|| f64::from(nearest).recip());
        let counters = TraceCounters::default();
        Ok(Self { map, frame, nearest, layers, taps: 256, bias: Some(0.0), counters })
    }

    /// Sets the number of taps.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] without any.
    pub fn with_taps(self, taps: u32) -> dsm_core::detail::Result<Self> {
        if taps == 0 {
            let reason = "there must be at least 1 a light";
            return Err(Error::Setting { setting: "taps", reason });
        }
        Ok(Self { taps, ..self })
    }

    /// Sets the depth bias, in scene units.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless it is finite.
    pub fn with_bias(self, bias: f64) -> dsm_core::detail::Result<Self> {
        if !bias.is_finite() {
            return Err(Error::Setting { setting: "bias", reason: "it must be finite" });
        }
        Ok(Self { bias: Some(bias), ..self })
    }

    /// Sets the depth bias to the side of a pixel at the receiver's depth.
    #[must_use]
    pub fn with_pixel_bias(self) -> Self {
        Self { bias: None, ..self }
    }

    /// The light's frame.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// Counts of the taps so far, as rays.
    #[must_use]
    pub fn statistics(&self) -> TraceStatistics {
        self.counters.get()
    }

    /// The light left at one tap; `None` where it is all of it, for want of a
    /// place in the map.
    fn tap(
        &self,
        pixels: &M::Reader<'_>,
        [receiver, light]: [DVec3; 2],
        counted: &mut TraceStatistics,
    ) -> Result<Option<M::Value>, M::Error> {
        let Some((pixel, depth)) = self.place(receiver, light, counted) else { return Ok(None) };
        pixels.with_pixel(pixel, |of, pixel| match self.layers {
            FilteredLayers::Shallowest => of.behind_first(pixel, depth),
            FilteredLayers::All => of.behind_all(pixel, depth),
        })
    }

    /// Which pixel a tap reads, and at which depth.
    fn place(
        &self,
        receiver: DVec3,
        light: DVec3,
        counted: &mut TraceStatistics,
    ) -> Option<([u32; 2], f32)> {
        counted.rays += 1;
        let depth = self.frame.camera_point(receiver).z;
        let is_deeper = depth > self.frame.light_depth();
        counted.behind_light += u64::from(!is_deeper);
        let ray = self.frame.ray(receiver, light, 0.0)?;
        let nearest = self.nearest.filter(|&nearest| nearest >= ray.range()[0])?;
        let place = ray.at(nearest);
        let size = self.frame.size().map(f64::from);
        if !(0..2).all(|axis| (0.0..size[axis]).contains(&place[axis])) {
            counted.outside_map += 1;
            return None;
        }
        let bias = self.bias.unwrap_or_else(|| self.frame.footprint(depth));
        Some((place.map(|at| at as u32), (depth - bias) as f32))
    }
}

impl<M: TracedMap> LightVisibility for SoftPercentageCloser<M> {
    type Value = M::Value;
    type Error = M::Error;

    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> Result<M::Value, M::Error> {
        let pixels = self.map.reader();
        let mut counted = TraceStatistics::default();
        let mut mean = LightMean::new();
        let mut points = light.samples(receiver, self.taps, seed);
        let tapped = points.try_for_each(|point| {
            let left = self.tap(&pixels, [receiver, point], &mut counted)?;
            mean.add(left.unwrap_or(M::Value::CLEAR));
            Ok(())
        });
        self.counters.add(counted);
        tapped.map(|()| mean.of(self.taps))
    }
}
