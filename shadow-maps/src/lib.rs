//! Shadow maps, a module a method.
//!
//! [`plain`]: one depth a sample, with percentage closer filtering. Maps of
//! fragments, planes with coverage masks that are traced for the soft shadows of
//! area lights, are baked and queried through the crate `deepshadow`.

mod fragments;
pub mod plain;

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::{
        fragments::{
            builder::{FragmentBuilder, FragmentCounts},
            columns::FragmentColumns,
            fragment::Fragment,
            map::FragmentMap,
            store::{Folded, FragmentKeys, FragmentTile, Fragments, bake_fragments},
            tracer::{FragmentTracer, TraceScratch},
        },
        plain::{blocking::Blocking, shadow::PercentageCloserShadow},
    };
}
