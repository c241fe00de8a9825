//! A whole OpenVDB file.

use dsm_scene::detail::GridChoice;
use dsm_scene::detail::volume_from_bytes;
use glam::DVec3;

/// Reads the density, and the first grid of whatever name, and asks both for values.
///
/// # Panics
///
/// If a density is not a number.
pub fn vdb(bytes: &[u8]) -> bool {
    let mut is_read = false;
    for choice in [None, Some(GridChoice::named("flame"))] {
        let Ok(volume) = volume_from_bytes(bytes, choice.as_ref()) else { continue };
        is_read = true;
        let bounds = volume.bounds();
        for step in 0..5 {
            let place = bounds.min.lerp(bounds.max, f64::from(step) / 4.0);
            let density = volume.density(if place.is_finite() { place } else { DVec3::ZERO });
            assert!(density.is_finite() && density >= 0.0, "{density} at {place}");
        }
    }
    is_read
}
