//! A map's metadata as the header of a deep image.

use deep_exr::{AlphaChannels, Attribute, Window, WriteOptions};
use dsm_core::detail::PixelWindow;

use super::camera_reading::z_reversed;
use super::export_options::ExportOptions;
use crate::metadata::Metadata;

const DEEP_IMAGE_STATE: &str = "deepImageState";

/// The image of a map with these metadata, and the names of attributes that it
/// cannot have. Those that say how an image is built speak of another one.
pub(super) fn image_options(
    metadata: &Metadata,
    export: &ExportOptions,
) -> Result<(WriteOptions, Vec<String>), deep_exr::Error> {
    let info = &metadata.info;
    let alpha = if metadata.channels == 1 { AlphaChannels::Mono } else { AlphaChannels::Colour };
    let mut options = WriteOptions::new(metadata.width, metadata.height)
        .corner(info.data_window.map_or([0; 2], |window| window.min))
        .layout(export.layout)
        .compression(export.compression)
        .alpha(alpha, export.sample_type);
    let display_window = info.display_window.map(|PixelWindow { min, max }| Window { min, max });
    if let Some(window) = display_window.filter(|window| window.is_valid()) {
        options = options.display_window(window);
    }
    let mut left_out = Vec::new();
    for (name, kept) in &metadata.attributes {
        let attribute = Attribute::new(name.as_str(), kept.type_name(), kept.bytes());
        if name == DEEP_IMAGE_STATE || options.set(attribute).is_err() {
            left_out.push(name.clone());
        }
    }
    if export.deep_image_state {
        // Sorted, and without overlaps: that is how samples are made.
        const TIDY: u8 = 3;
        options.set(Attribute::new(DEEP_IMAGE_STATE, DEEP_IMAGE_STATE, [TIDY]))?;
    }
    // Column-vector matrices become row-vector ones: glam's columns are
    // OpenEXR's rows. Their numbers become `f32`.
    let camera = info.camera.unwrap_or_default();
    let matrices = [
        ("worldToCamera", camera.world_to_camera.map(z_reversed)),
        ("worldToNDC", camera.world_to_ndc),
    ];
    for (name, matrix) in matrices {
        let Some(matrix) = matrix.map(|matrix| matrix.as_mat4()) else { continue };
        if matrix.is_finite() {
            options.set(Attribute::floats(name, "m44f", &matrix.to_cols_array()))?;
        } else {
            left_out.push(name.to_owned());
        }
    }
    Ok((options, left_out))
}
