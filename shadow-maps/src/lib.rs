//! Shadow maps, a module a method.
//!
//! [`plain`]: one depth a sample, with percentage closer filtering. Maps of
//! fragments, planes with coverage masks that are traced for the soft shadows of
//! area lights, and prefiltered and attenuation maps, whose soft shadows are looked up,
//! are baked and queried through the crate `deepshadow`.

mod attenuation;
mod fragments;
pub mod plain;
mod prefilter;
mod views;

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::{
        attenuation::{
            bake::write_attenuation,
            builder::{AttenuationBuilder, AttenuationCounts},
            cached::CachedAttenuation,
            keys::AttenuationKeys,
            map::AttenuationMap,
            shadow::AttenuationShadow,
            source::AttenuationSource,
            store::Attenuation,
        },
        fragments::{
            bake::bake_fragments,
            builder::{FragmentBuilder, FragmentCounts},
            columns::FragmentColumns,
            fragment::Fragment,
            keys::{FragmentKeys, MediaKeys},
            map::FragmentMap,
            media::columns::MediaColumns,
            store::Fragments,
            tile::FragmentTile,
            tracer::{FragmentTracer, TraceScratch},
        },
        plain::{blocking::Blocking, shadow::PercentageCloserShadow},
        prefilter::{
            accumulate::Accumulate,
            bake::{bake_prefiltered, write_prefiltered},
            builder::{CollectedHits, ListBuilder, ListCounts},
            cached::CachedPrefiltered,
            epsilon::Epsilon,
            hybrid::HybridShadow,
            keys::{Filtering, PrefilteredKeys},
            level_plan::LevelGeometry,
            light_parts::square_width,
            lists::{FragmentList, FragmentLists},
            map::PrefilteredMap,
            merge::MergedDepth,
            settings::PrefilterSettings,
            shadow::PrefilteredShadow,
            store::Prefiltered,
            tile::PrefilteredTile,
        },
        views::{
            bake::{ViewsBuilder, view_points},
            depth_view::DepthView,
            keys::ViewsKeys,
            options::TraceOptions,
            store::Views,
            tracer::{RayFate, ViewsTracer},
            view_tile::ViewTile,
        },
    };
}
