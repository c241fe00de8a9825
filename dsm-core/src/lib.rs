//! Deep shadow maps: visibility as a function of depth in every pixel of a shadow
//! camera, after Lokovic & Veach, *Deep Shadow Maps* (SIGGRAPH 2000).
//!
//! The data goes one way:
//! [`HitSource`] → [`RayHits`] of one ray → transmittance function → the
//! pixel filter's weighted sum → [`VisibilityFunction`]
//! under a [`Tolerance`] → [`PixelLists`] → [`DeepMap`] → [`filtered_lookup`].
//! [`Baker`] takes it from the source to the map, tile by tile.
//!
//! This crate does no input or output.

mod bake;
mod camera;
mod compress;
mod curve;
mod error;
mod field;
mod filter;
mod hits;
mod in_file;
mod light;
mod mip;
mod progress;
pub mod random;
mod shadow;
mod tolerance;
mod transmittance;
mod visibility;

pub use bake::baker::Baker;
pub use bake::settings::BakeSettings;
pub use camera::map_info::MapInfo;
pub use camera::ray::Ray;
pub use camera::shadow_camera::{DepthKind, ShadowCamera};
pub use camera::view::{Projection, View};
pub use camera::view_raster::ViewRaster;
pub use compress::quantization::Quantization;
pub use error::{Error, Result};
pub use field::filtered::filtered_lookup;
pub use field::footprint::Footprint;
pub use field::map::DeepMap;
pub use field::pixel_lists::{PixelLists, PixelListsBuilder};
pub use field::pyramid::{LevelChoice, Pyramid};
pub use field::receiver::Receiver;
pub use field::shadow::{Bias, BiasSummary, FilteredShadow, ShadowLookup};
pub use field::visibility_field::VisibilityField;
pub use filter::{Filter, FilterShape};
pub use hits::hit::{RayHits, SurfaceHit, VolumeSample};
pub use hits::hit_source::{HitSource, RaySource};
pub use hits::sampling::PixelSampling;
pub use hits::tile_hits::TileHits;
pub use hits::tile_samples::{SamplePoint, TileSamples};
pub use light::{AreaLight, LightShape};
pub use progress::Progress;
pub use shadow::{Facing, LightVisibility, OcclusionTracer, ShadedPoint};
pub use tolerance::Tolerance;
pub use transmittance::{Rgb, Transmittance};
pub use visibility::function::VisibilityFunction;
pub use visibility::vertex::Vertex;

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::bake::exact::{ExactPixel, SampledPixel};
    pub use crate::bake::tile::BakedTile;
    pub use crate::camera::pixel_window::PixelWindow;
    pub use crate::camera::projection::MapProjection;
    pub use crate::compress::compressor::{Compression, Compressor};
    pub use crate::compress::greedy::{End, GreedyCompressor, compress};
    pub use crate::compress::paper_greedy::paper_greedy;
    pub use crate::curve::sweep::{VisibilitySweep, WeightedTransmittance};
    pub use crate::curve::transmittance_builder::TransmittanceBuilder;
    pub use crate::curve::transmittance_function::TransmittanceFunction;
    pub use crate::field::pixel_lists::PixelListsView;
    pub use crate::field::visibility_field::BlockVisitor;
    pub use crate::hits::hit::VolumeSegment;
    pub use crate::in_file::InFile;
    pub use crate::light::LightExtent;
    pub use crate::mip::MipPyramid;
    pub use crate::visibility::difference::{DifferenceSummary, VisibilityDifference};
    pub use crate::visibility::function::VisibilityView;
    pub use crate::visibility::polyline::Polyline;
    pub use crate::visibility::product::VisibilityProduct;
    pub use crate::visibility::vertex::SumVertex;
}
