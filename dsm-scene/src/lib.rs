//! What a shadow camera looks at.
//!
//! No scene type is implemented yet: a renderer brings what its rays meet as
//! [`dsm_core::RayHits`].
