//! Deep shadow maps: the fraction of light that reaches every depth through
//! every pixel of a shadow camera, after Lokovic & Veach, *Deep Shadow Maps*
//! (SIGGRAPH 2000).
//!
//! The data goes one way:
//! [`HitSource`] → [`RayHits`] of one ray → [`TransmittanceFunction`] → the
//! pixel filter's weighted sum ([`VisibilitySweep`]) → [`VisibilityFunction`]
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
mod light;
mod mip;
mod random;
mod shadow;
mod tolerance;
mod transmittance;
mod visibility;

pub use bake::baker::{BakeProgress, Baker};
pub use bake::exact::{ExactPixel, SampledPixel};
pub use bake::settings::BakeSettings;
pub use bake::tile::BakedTile;
pub use camera::map_info::MapInfo;
pub use camera::pixel_window::PixelWindow;
pub use camera::projection::MapProjection;
pub use camera::ray::Ray;
pub use camera::shadow_camera::{DepthKind, ShadowCamera};
pub use camera::view::{Projection, View};
pub use camera::view_raster::ViewRaster;
pub use compress::greedy::{End, GreedyCompressor, compress};
pub use compress::paper_greedy::paper_greedy;
pub use compress::quantization::Quantization;
pub use curve::sweep::{VisibilitySweep, WeightedTransmittance};
pub use curve::transmittance_builder::TransmittanceBuilder;
pub use curve::transmittance_function::TransmittanceFunction;
pub use error::{Error, Result};
pub use field::filtered::filtered_lookup;
pub use field::footprint::Footprint;
pub use field::map::DeepMap;
pub use field::pixel_lists::{PixelLists, PixelListsBuilder, PixelListsView};
pub use field::pyramid::{LevelChoice, Pyramid};
pub use field::receiver::Receiver;
pub use field::shadow::{Bias, BiasSummary, FilteredShadow, ShadowLookup};
pub use field::visibility_field::{BlockVisitor, VisibilityField};
pub use filter::{Filter, FilterShape};
pub use hits::hit::{RayHits, SurfaceHit, VolumeSample, VolumeSegment};
pub use hits::hit_source::{HitSource, RaySource};
pub use hits::sampling::PixelSampling;
pub use hits::tile_hits::TileHits;
pub use hits::tile_samples::{SamplePoint, TileSamples};
pub use light::{AreaLight, LightExtent, LightShape};
pub use mip::MipPyramid;
pub use random::next_bits;
pub use shadow::{Facing, LightVisibility, OcclusionTracer, ShadedPoint};
pub use tolerance::Tolerance;
pub use transmittance::{Rgb, Transmittance};
pub use visibility::difference::{DifferenceSummary, VisibilityDifference};
pub use visibility::function::{VisibilityFunction, VisibilityView};
pub use visibility::polyline::Polyline;
pub use visibility::product::VisibilityProduct;
pub use visibility::vertex::{SumVertex, Vertex};
