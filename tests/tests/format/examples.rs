//! The maps of the document and of the golden files.

use std::path::Path;

use dsm_core::detail::PixelLists;
use dsm_core::{
    DeepMap, Filter, FilterShape, MapInfo, Rgb, ShadowCamera, Tolerance, Transmittance, Vertex,
};
use dsm_io::{AchievedError, Attribute, Metadata, Packing, WriteOptions, write_map};
use glam::{DMat4, Mat4, Vec3, Vec4};

use crate::pixels::build;

/// A map and how it is written.
pub(crate) struct Example<T> {
    pub(crate) metadata: Metadata,
    pub(crate) pixels: PixelLists<T>,
    pub(crate) error: AchievedError,
    pub(crate) options: WriteOptions,
}

impl<T: Transmittance> Example<T> {
    /// The file's bytes.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("example.dsm");
        self.write(&path).unwrap();
        std::fs::read(path).unwrap()
    }

    pub(crate) fn write(&self, path: &Path) -> dsm_io::detail::Result<u64> {
        let map = DeepMap::new(self.metadata.info, self.pixels.clone());
        write_map(path, self.metadata.clone(), &map, self.error, self.options)
    }
}

/// The example of the document: 3 × 1 pixels in tiles of 2 × 2, of which the
/// second is empty.
pub(crate) fn document() -> Example<f32> {
    let info = MapInfo::new().with_tolerance(Tolerance::new(0.0625).unwrap());
    let mut metadata = Metadata::new(3, 1, 1, info);
    metadata.software = "example".to_owned();
    let step = vec![Vertex::new(2.0, 1.0), Vertex::new(2.0, 0.25)];
    let ramp = vec![Vertex::new(3.0, 1.0), Vertex::new(5.0, 0.5)];
    Example {
        metadata,
        pixels: build(3, 1, [step, ramp, Vec::new()]),
        error: AchievedError { max: 0.03125, mean: 0.015_625 },
        options: WriteOptions::default().with_tile_size(2),
    }
}

fn metadata(channels: u8) -> Metadata {
    let view = Mat4::from_translation(Vec3::new(-0.1, 0.2, -5.0));
    let projection = Mat4::from_diagonal(Vec4::new(0.3, -0.7, 1.0, 1.0));
    // The files were written when matrices were `f32`: by their shortest decimals.
    let decimal = |number: f32| number.to_string().parse().unwrap();
    let wide = |matrix: Mat4| DMat4::from_cols_array(&matrix.to_cols_array().map(decimal));
    let camera = ShadowCamera {
        world_to_camera: Some(wide(view)),
        world_to_ndc: Some(wide(projection * view)),
    };
    let info = MapInfo::new()
        .with_camera(camera)
        .with_tolerance(Tolerance::new(0.02).unwrap())
        .with_samples(16)
        .with_filter(Filter::new(FilterShape::Tent, 2.0).unwrap());
    let mut metadata = Metadata::new(19, 13, channels, info);
    metadata.software = "golden 1.0".to_owned();
    metadata.attributes.insert("owner".to_owned(), Attribute::string("lighting"));
    metadata
}

/// 19 × 13 pixels: every fifth is empty, the last tile too; of the coloured
/// ones, every other is grey.
fn pixels<T: Transmittance>() -> PixelLists<T> {
    build(
        19,
        13,
        (0..13_u16).flat_map(|y| (0..19_u16).map(move |x| (x, y))).map(|(x, y)| {
            if (x + y) % 5 == 0 || (x >= 16 && y >= 8) {
                return Vec::new();
            }
            let grey = x % 2 == 0;
            let mut vertices = Vec::new();
            let mut value = T::CLEAR;
            for k in 0..1 + (x * y) % 4 {
                let z = 1.0 + f32::from(y) * 0.125 + f32::from(k) * 0.5;
                let next = T::from_channels(|channel| {
                    let tint = if grey { 0.75 } else { 0.75 - 0.125 * channel as f32 };
                    value.channel(channel) * tint
                });
                vertices.extend([Vertex::new(z, value), Vertex::new(z, next)]);
                value = next;
            }
            vertices
        }),
    )
}

fn golden<T: Transmittance>(packing: Packing) -> Example<T> {
    Example {
        metadata: metadata(T::CHANNELS as u8),
        pixels: pixels(),
        error: AchievedError { max: 0.015_625, mean: 0.007_812_5 },
        options: WriteOptions::default().with_tile_size(8).with_packing(packing),
    }
}

pub(crate) fn mono(packing: Packing) -> Example<f32> {
    golden(packing)
}

pub(crate) fn coloured(packing: Packing) -> Example<Rgb> {
    golden(packing)
}
