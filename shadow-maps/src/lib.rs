//! Shadow maps, a module a method.
//!
//! [`plain`]: one depth a sample, with percentage closer filtering.
//! [`fragments`]: planes with coverage masks, traced for the soft shadows of
//! area lights.

pub mod fragments;
pub mod plain;
