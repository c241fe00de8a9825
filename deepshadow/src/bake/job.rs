//! One bake.

use std::ops::ControlFlow;

use dsm_core::detail::Quantization;
use dsm_core::{LightExtent, Progress, Rgb, Tolerance, Transmittance, ViewRaster};
use dsm_io::detail::Crop;
use dsm_io::{Codec, Metadata};
use dsm_scene::Light;

use super::occluders::{AnyHitSource, Occluders};
use super::report::BakeReport;
use super::settings::{Bake, Channels};
use crate::error::Result;

/// What depths are moved by at most, of the width of the finest thing: two hairs that
/// touch stay one behind the other, and what lies between their middles is told apart.
const SHARE_OF_WIDTH: f64 = 0.25;

/// A bake, as a kind of map sees it.
pub(crate) struct Job<'a> {
    occluders: &'a dyn Occluders,
    pub(crate) light: &'a Light,
    pub(crate) extent: LightExtent,
    pub(crate) settings: &'a Bake,
    coloured: bool,
    watch: &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync),
}

/// Hits through a view.
pub(crate) enum Seen<'a> {
    Mono(AnyHitSource<'a, f32>),
    Rgb(AnyHitSource<'a, Rgb>),
}

impl<'a> Job<'a> {
    /// A bake of what `light` sees of `occluders`.
    pub(crate) fn new(
        occluders: &'a dyn Occluders,
        light: &'a Light,
        settings: &'a Bake,
        watch: &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<Self> {
        let coloured = match settings.channels {
            Channels::Auto => occluders.is_coloured(),
            Channels::Mono => false,
            Channels::Rgb => true,
        };
        let extent = light.area()?.extent();
        Ok(Self { occluders, light, extent, settings, coloured, watch })
    }
}

impl Job<'_> {
    /// What is seen of the occluders, with as many channels as the map has.
    pub(crate) fn look(&self, view: &ViewRaster) -> Result<Seen<'_>> {
        if self.coloured {
            self.occluders.rgb(view).map(Seen::Rgb)
        } else {
            self.occluders.mono(view).map(Seen::Mono)
        }
    }

    /// Whether the map has a channel for each colour.
    pub(crate) const fn is_coloured(&self) -> bool {
        self.coloured
    }

    /// What is seen of the occluders, with one channel.
    pub(crate) fn mono(&self, view: &ViewRaster) -> Result<AnyHitSource<'_, f32>> {
        self.occluders.mono(view)
    }

    /// What is seen of the occluders, with three channels.
    pub(crate) fn rgb(&self, view: &ViewRaster) -> Result<AnyHitSource<'_, Rgb>> {
        self.occluders.rgb(view)
    }

    /// The grids that vertices are rounded to, of codec `quantized`.
    pub(crate) fn quantization(&self) -> Result<Option<Quantization>> {
        if self.settings.codec != Codec::Quantized {
            return Ok(None);
        }
        Ok(Some(match (self.settings.depth_error, self.occluders.finest_width()) {
            (Some(error), _) => Quantization::within(error)?,
            (None, Some(width)) => {
                Quantization::default().with_depth_error(width * SHARE_OF_WIDTH)?
            }
            (None, None) => Quantization::default(),
        }))
    }

    /// The part of the map that is baked, if not all of it.
    pub(crate) fn crop(&self) -> Option<Crop> {
        self.settings.crop.map(Crop::of_edges)
    }

    /// Tells the caller how far the bake has come.
    pub(crate) fn watch(&self, progress: Progress) -> ControlFlow<()> {
        (self.watch)(progress)
    }

    /// Adds to the header what the caller wants it to say.
    pub(crate) fn describe(&self, metadata: &mut Metadata) {
        metadata.software.clone_from(&self.settings.software);
        metadata.info.light = Some(self.extent);
        let attributes = self.settings.attributes.iter();
        metadata.attributes.extend(attributes.map(|(name, value)| (name.clone(), value.clone())));
    }

    /// The report of a bake of `per_pixel` samples a pixel.
    pub(crate) fn report<T: Transmittance>(
        &self,
        per_pixel: u32,
        tolerance: Tolerance,
        baked: dsm_io::detail::BakeReport,
    ) -> BakeReport {
        let dsm_io::detail::BakeReport { hits, cut_pixels, gained, bytes, smaller_tiles } = baked;
        let [width, height] = self.settings.resolution;
        let [left, top, right, bottom] = self.settings.crop.unwrap_or([0, 0, width, height]);
        let pixels = u64::from(right - left) * u64::from(bottom - top);
        let samples = pixels * u64::from(per_pixel);
        let (tolerance, channels) = (tolerance.epsilon(), T::CHANNELS);
        BakeReport { samples, hits, cut_pixels, gained, tolerance, channels, bytes, smaller_tiles }
    }
}
