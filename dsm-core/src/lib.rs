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
mod difference;
mod error;
mod filter;
mod hit;
mod hit_source;
mod light;
mod lookup;
mod map;
mod mip;
mod moved_depths;
mod pixel_lists;
mod polyline;
mod product;
mod random;
mod sampling;
mod search;
mod shadow;
mod tile_hits;
mod tile_samples;
mod transmittance;
mod visibility;
mod walk;

pub use bake::{BakeProgress, BakeSettings, BakedTile, Baker, ExactPixel, SampledPixel};
pub use camera::{DepthKind, PixelWindow, ShadowCamera};
pub use compress::greedy::{End, GreedyCompressor, compress};
pub use compress::paper_greedy::paper_greedy;
pub use compress::quantization::Quantization;
pub use compress::tolerance::Tolerance;
pub use curve::sweep::{VisibilitySweep, WeightedTransmittance};
pub use curve::transmittance_builder::TransmittanceBuilder;
pub use curve::transmittance_function::TransmittanceFunction;
pub use curve::vertex::{SumVertex, Vertex};
pub use difference::{DifferenceSummary, VisibilityDifference};
pub use error::{Error, Result};
pub use filter::{Filter, FilterShape};
pub use hit::{RayHits, SurfaceHit, VolumeSample, VolumeSegment};
pub use hit_source::{HitSource, RaySource};
pub use light::{AreaLight, LightExtent, LightShape};
pub use lookup::field::{BlockVisitor, VisibilityField};
pub use lookup::filtered::filtered_lookup;
pub use lookup::footprint::Footprint;
pub use lookup::projection::MapProjection;
pub use lookup::pyramid::{LevelChoice, Pyramid};
pub use lookup::receiver::Receiver;
pub use lookup::shadow::{Bias, BiasSummary, FilteredShadow, ShadowLookup};
pub use map::{DeepMap, MapInfo};
pub use mip::MipPyramid;
pub use pixel_lists::{PixelLists, PixelListsBuilder, PixelListsView};
pub use polyline::Polyline;
pub use product::VisibilityProduct;
pub use random::next_bits;
pub use sampling::PixelSampling;
pub use shadow::{Facing, LightVisibility, OcclusionTracer, ShadedPoint};
pub use tile_hits::TileHits;
pub use tile_samples::{SamplePoint, TileSamples};
pub use transmittance::{Rgb, Transmittance};
pub use visibility::{VisibilityFunction, VisibilityView};
