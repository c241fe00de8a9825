//! What a shadow camera looks at.
//!
//! Scenes answer [`dsm_core::HitSource`]: every surface hit and volume sample
//! along the rays of a shadow camera. This crate holds no scene type yet; a
//! renderer brings its own hits through that trait.
