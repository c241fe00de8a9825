//! The header of a deep image that is written.

use std::collections::BTreeMap;

use dsm_core::{PixelWindow, ShadowCamera};
use half::f16;

use super::channels::{ChannelPlan, ExrChannel, ExrChannelType};
use super::codec::Packing;
use super::grid::BlockGrid;
use super::header::{FARTHEST_PIXEL, STRUCTURE};
use super::rows::DeepRows;
use crate::{Attribute, Error, Metadata, Result};

/// How the pixels of a written image are cut into chunks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExportLayout {
    /// Scan lines over the whole width, each a chunk.
    #[default]
    ScanLines,
    /// Square tiles, without smaller levels.
    Tiles {
        /// Width and height of a tile in pixels, 1 to 4096.
        size: u32,
    },
}

/// How a written image stores opacities. Depths are always 32-bit floats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExportSampleType {
    /// 32-bit floats.
    #[default]
    Float,
    /// 16-bit floats: light that passes a sample is then off by up to 2⁻¹¹.
    Half,
}

/// How the chunks of a written image are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExportCompression {
    /// Deflate, a scan line or tile at a time.
    #[default]
    Zips,
    /// Run lengths.
    Rle,
    /// Not at all.
    None,
}

impl ExportSampleType {
    /// The largest opacity below 1.
    const fn largest_below_one(self) -> f32 {
        match self {
            Self::Float => 1.0 - f32::EPSILON / 2.0,
            Self::Half => 1.0 - 1.0 / 2048.0,
        }
    }

    /// The nearest opacity that this type holds; 1 only for 1 itself, because
    /// what is 1 lets no light through.
    pub(crate) fn round(self, opacity: f64) -> f32 {
        if opacity >= 1.0 {
            return 1.0;
        }
        let nearest = match self {
            Self::Float => opacity as f32,
            Self::Half => f16::from_f64(opacity).to_f32(),
        };
        nearest.min(self.largest_below_one())
    }

    const fn channel_type(self) -> ExrChannelType {
        match self {
            Self::Float => ExrChannelType::Float,
            Self::Half => ExrChannelType::Half,
        }
    }
}

impl ExportCompression {
    pub(super) const fn packing(self) -> Packing {
        match self {
            Self::Zips => Packing::Zips,
            Self::Rle => Packing::Rle,
            Self::None => Packing::None,
        }
    }
}

/// Longer names need a flag in the version field.
const SHORT_NAME: usize = 31;
const LONGEST_NAME: usize = 255;

/// Everything that is known before the pixels are.
pub(crate) struct ExportHeader {
    grid: BlockGrid,
    channels: Vec<ExrChannel>,
    attributes: BTreeMap<Vec<u8>, (Vec<u8>, Vec<u8>)>,
    left_out: Vec<String>,
}

impl ExportHeader {
    /// The header for a map with these metadata.
    pub(crate) fn new(
        metadata: &Metadata,
        layout: ExportLayout,
        sample_type: ExportSampleType,
        compression: ExportCompression,
        deep_image_state: bool,
    ) -> Result<Self> {
        let size = [metadata.width, metadata.height];
        let data_window = data_window(metadata)?;
        let grid = match layout {
            ExportLayout::ScanLines => BlockGrid::new(size, [size[0], 1], false, data_window.min),
            ExportLayout::Tiles { size: tile @ 1..=4096 } => {
                BlockGrid::new(size, [tile; 2], true, data_window.min)
            }
            ExportLayout::Tiles { .. } => {
                return Err(Error::caller("tiles must be 1 to 4096 pixels wide"));
            }
        };
        let mut header = Self {
            grid,
            channels: channels(metadata.channels, sample_type),
            attributes: BTreeMap::new(),
            left_out: Vec::new(),
        };
        header.keep_attributes(&metadata.attributes);
        if deep_image_state {
            // Sorted, and without overlaps: that is how samples are made.
            const TIDY: u8 = 3;
            header.set("deepImageState", "deepImageState", [TIDY]);
        }
        header.set_camera(metadata.info.camera.unwrap_or_default());
        header.set_structure(layout, compression);
        header.set_window("dataWindow", data_window);
        let display_window = metadata.info.display_window.filter(|&window| is_readable(window));
        header.set_window("displayWindow", display_window.unwrap_or(data_window));
        Ok(header)
    }

    /// How the image is cut into chunks.
    pub(crate) const fn grid(&self) -> &BlockGrid {
        &self.grid
    }

    /// No pixels yet, for a block of this width.
    pub(crate) fn rows(&self, width: u32) -> Option<DeepRows> {
        ChannelPlan::new(&self.channels).map(|plan| DeepRows::new(width, &plan))
    }

    /// Names of attributes that are not written.
    pub(crate) fn left_out(&self) -> &[String] {
        &self.left_out
    }

    pub(super) fn channels(&self) -> &[ExrChannel] {
        &self.channels
    }

    /// The file's first bytes, up to the offset table. Their number does not
    /// depend on `max_samples`.
    pub(super) fn bytes(&self, max_samples: u32) -> Vec<u8> {
        const VERSION: u32 = 2;
        const LONG_NAMES: u32 = 0x400;
        const DEEP: u32 = 0x800;
        let max_samples = i32::try_from(max_samples).unwrap_or(i32::MAX);
        let mut attributes = self.attributes.clone();
        let value = max_samples.to_le_bytes().to_vec();
        attributes.insert(b"maxSamplesPerPixel".to_vec(), (b"int".to_vec(), value));
        let is_long = |(name, (type_name, _)): (&Vec<u8>, &(Vec<u8>, Vec<u8>))| {
            name.len().max(type_name.len()) > SHORT_NAME
        };
        let long_names = if attributes.iter().any(is_long) { LONG_NAMES } else { 0 };
        let mut bytes = exr::meta::magic_number::BYTES.to_vec();
        bytes.extend((VERSION | DEEP | long_names).to_le_bytes());
        for (name, (type_name, value)) in &attributes {
            for text in [name, type_name] {
                bytes.extend(text);
                bytes.push(0);
            }
            bytes.extend((value.len() as u32).to_le_bytes());
            bytes.extend(value);
        }
        bytes.push(0);
        bytes
    }

    fn set(&mut self, name: &str, type_name: &str, value: impl Into<Vec<u8>>) {
        self.attributes.insert(name.into(), (type_name.into(), value.into()));
    }

    fn set_default(&mut self, name: &str, type_name: &str, value: impl Into<Vec<u8>>) {
        let default = || (type_name.into(), value.into());
        self.attributes.entry(name.into()).or_insert_with(default);
    }

    fn set_window(&mut self, name: &str, window: PixelWindow) {
        let numbers = [window.min, window.max].concat();
        self.set(name, "box2i", numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>());
    }

    /// The map's free attributes, byte for byte. Those that say how an image
    /// is built speak of another one.
    fn keep_attributes(&mut self, attributes: &BTreeMap<String, Attribute>) {
        for (name, attribute) in attributes {
            let names = [name.as_str(), attribute.type_name()];
            let can_be_named = names.iter().all(|text| {
                (1..=LONGEST_NAME).contains(&text.len()) && !text.as_bytes().contains(&0)
            });
            let own_type = OWN_TYPES.iter().find(|(own, _)| own == name).map(|(_, own)| *own);
            let allowed = match own_type {
                Some(own_type) => attribute.type_name() == own_type,
                None => name != "deepImageState" && !STRUCTURE.contains(&name.as_str()),
            };
            let fits = i32::try_from(attribute.bytes().len()).is_ok();
            if can_be_named && allowed && fits && attribute.has_its_types_size() {
                self.set(name, attribute.type_name(), attribute.bytes());
            } else {
                self.left_out.push(name.clone());
            }
        }
    }

    /// Column-vector matrices become row-vector ones: glam's columns are
    /// OpenEXR's rows. Their numbers become `f32`.
    fn set_camera(&mut self, camera: ShadowCamera) {
        let matrices =
            [("worldToCamera", camera.world_to_camera), ("worldToNDC", camera.world_to_ndc)];
        for (name, matrix) in matrices {
            let Some(matrix) = matrix else { continue };
            let matrix = matrix.as_mat4();
            if matrix.is_finite() {
                let numbers = matrix.to_cols_array();
                let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
                self.set(name, "m44f", bytes);
            } else {
                self.left_out.push(name.to_owned());
            }
        }
    }

    fn set_structure(&mut self, layout: ExportLayout, compression: ExportCompression) {
        let mut list = Vec::new();
        for channel in &self.channels {
            let kind: i32 = match channel.channel_type {
                ExrChannelType::Uint => 0,
                ExrChannelType::Half => 1,
                ExrChannelType::Float => 2,
            };
            list.extend(channel.name.bytes());
            list.push(0);
            list.extend([kind, 0, 1, 1].iter().flat_map(|word| word.to_le_bytes()));
        }
        list.push(0);
        self.set("channels", "chlist", list);
        let chunks = i32::try_from(self.grid.count()).unwrap_or(i32::MAX);
        self.set("chunkCount", "int", chunks.to_le_bytes());
        self.set("compression", "compression", [compression.packing().id()]);
        self.set("lineOrder", "lineOrder", [0]);
        self.set("version", "int", 1_i32.to_le_bytes());
        let part_type = match layout {
            ExportLayout::ScanLines => "deepscanline",
            ExportLayout::Tiles { size } => {
                let size = size.to_le_bytes();
                self.set("tiles", "tiledesc", [&size[..], &size, &[0]].concat());
                "deeptile"
            }
        };
        self.set("type", "string", part_type);
        self.set_default("name", "string", "deep");
        self.set_default("pixelAspectRatio", "float", 1_f32.to_le_bytes());
        self.set_default("screenWindowCenter", "v2f", [0; 8]);
        self.set_default("screenWindowWidth", "float", 1_f32.to_le_bytes());
    }
}

/// Attributes that every image must have, and that maps may keep for it.
const OWN_TYPES: [(&str, &str); 4] = [
    ("name", "string"),
    ("pixelAspectRatio", "float"),
    ("screenWindowCenter", "v2f"),
    ("screenWindowWidth", "float"),
];

/// The pixels that the map covers. Every file can hold what readers accept.
fn data_window(metadata: &Metadata) -> Result<PixelWindow> {
    let size = [metadata.width, metadata.height].map(i64::from);
    let min = metadata.info.data_window.map_or([0, 0], |window| window.min);
    let far = [0, 1].map(|axis| i64::from(min[axis]) + size[axis] - 1);
    let max = far.map(|n| i32::try_from(n).unwrap_or(i32::MAX));
    let window = PixelWindow { min, max };
    if is_readable(window) {
        Ok(window)
    } else {
        Err(Error::caller("the pixels of an OpenEXR reach 2^30 at most"))
    }
}

/// Whether readers accept the window.
fn is_readable(window: PixelWindow) -> bool {
    let near = |n: &i32| n.unsigned_abs() < FARTHEST_PIXEL.unsigned_abs();
    !window.size().contains(&0) && window.min.iter().chain(&window.max).all(near)
}

/// In the order in which chunks store them. `A` stands beside the colours'
/// own opacities for programs that know no other.
fn channels(count: u8, sample_type: ExportSampleType) -> Vec<ExrChannel> {
    let alphas: &[&str] = if count == 1 { &["A"] } else { &["A", "AB", "AG", "AR"] };
    let channel = |name: &&str, channel_type| ExrChannel { name: (*name).to_owned(), channel_type };
    let alphas = alphas.iter().map(|name| channel(name, sample_type.channel_type()));
    alphas.chain(["Z", "ZBack"].iter().map(|name| channel(name, ExrChannelType::Float))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_lets_nothing_through_is_1() {
        for (sample_type, step) in [(ExportSampleType::Float, 24), (ExportSampleType::Half, 11)] {
            let below = 1.0 - 0.5_f32.powi(step);
            assert_eq!(sample_type.round(1.0), 1.0);
            assert_eq!(sample_type.round(1.0 - 1e-12), below);
            assert_eq!(sample_type.round(f64::from(below)), below);
            assert_eq!(sample_type.round(0.25), 0.25);
        }
        assert_eq!(ExportSampleType::Half.round(0.1), f16::from_f32(0.1).to_f32());
    }
}
