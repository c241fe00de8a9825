//! Deep shadow maps: visibility as a function of depth in every pixel of a shadow
//! camera, after Lokovic & Veach, *Deep Shadow Maps* (SIGGRAPH 2000).
//!
//! The data goes one way:
//! [`HitSource`] → [`RayHits`] of one ray → transmittance function → the
//! pixel filter's weighted sum → [`VisibilityFunction`]
//! under a [`Tolerance`] → lists of vertices → [`DeepMap`] → [`filtered_lookup`].
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
mod light_extent;
mod mip;
mod occlusion;
mod progress;
mod random;
mod shadow;
mod tolerance;
mod transmittance;
mod visibility;

pub use bake::{baker::Baker, settings::BakeSettings};
pub use camera::map_info::MapInfo;
pub use camera::{ray::Ray, shadow_camera::ShadowCamera};
pub use camera::{
    view::{Projection, View},
    view_raster::ViewRaster,
};
pub use compress::{
    compressor::{Compression, CompressionMethod},
    side::Side,
};
pub use error::Error;
pub use field::bias::Bias;
pub use field::{filtered::filtered_lookup, footprint::Footprint, receiver::Receiver};
pub use field::{map::DeepMap, pixel_lists::PixelListsBuilder};
pub use field::{pyramid::LevelChoice, visibility_field::VisibilityField};
pub use filter::{Filter, FilterShape};
pub use hits::hit::{RayHits, SurfaceHit, VolumeSample};
pub use hits::hit_source::{HitSource, RaySource};
pub use hits::sampling::PixelSampling;
pub use hits::{
    tile_hits::TileHits,
    tile_samples::{SamplePoint, TileSamples},
};
pub use light::AreaLight;
pub use light_extent::LightExtent;
pub use progress::Progress;
pub use shadow::{Facing, LightVisibility, OcclusionTracer, ShadedPoint};
pub use tolerance::Tolerance;
pub use transmittance::{Rgb, Transmittance};
pub use visibility::{function::VisibilityFunction, vertex::Vertex};

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::{
        bake::{
            exact::{ExactPixel, SampledPixel},
            tile::BakedTile,
        },
        camera::{pixel_window::PixelWindow, projection::MapProjection, shadow_camera::DepthKind},
        compress::{
            compressor::{ChosenCompressor, Compressor},
            greedy::{End, GreedyCompressor, compress},
            min_link::compressor::MinLinkCompressor,
            paper_greedy::paper_greedy,
            quantization::Quantization,
            rounded::{Rounded, RoundedCompressor},
        },
        curve::{
            optical_depth_chords::OpticalDepthChords,
            sweep::{VisibilitySweep, WeightedTransmittance},
            transmittance_builder::TransmittanceBuilder,
            transmittance_function::TransmittanceFunction,
        },
        error::Result,
        field::{
            bias::BiasSummary,
            filtered_shadow::FilteredShadow,
            pixel_lists::{PixelLists, PixelListsView},
            pyramid::Pyramid,
            shadow::ShadowLookup,
            visibility_field::BlockVisitor,
        },
        hits::hit::VolumeSegment,
        in_file::InFile,
        light_extent::LightShape,
        mip::MipPyramid,
        occlusion::Occlusion,
        visibility::{
            difference::{DifferenceSummary, VisibilityDifference},
            function::VisibilityView,
            moved_depths::largest_fall,
            polyline::Polyline,
            product::VisibilityProduct,
            vertex::SumVertex,
        },
    };

    pub mod random {
        pub use crate::random::{
            COMBINING_FACTOR, EMPTY_HASH, MIX32_FACTORS, combine, golden, mix, mix32, next_bits,
            scattered_seed, unit, unit32,
        };
    }
}
