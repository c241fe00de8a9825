//! Where a map looks from, and how points of the world lie in it.

pub(crate) mod map_info;
pub(crate) mod pixel_window;
pub(crate) mod projection;
pub(crate) mod shadow_camera;
