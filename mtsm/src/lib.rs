//! Multilayer shadow maps for area lights.
//!
//! The maps of this crate answer [`dsm_core::VisibilityField`] with their
//! first run of layers, so that the filtered lookup of `dsm-core` serves them
//! as it serves a deep shadow map. No layered map is implemented yet.
