//! Deep shadow maps.
