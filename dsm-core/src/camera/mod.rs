//! Shadow cameras, and the projection of world points into their maps.

pub(crate) mod map_info;
pub(crate) mod pixel_window;
pub(crate) mod projection;
pub(crate) mod ray;
pub(crate) mod shadow_camera;
pub(crate) mod view;
pub(crate) mod view_raster;
