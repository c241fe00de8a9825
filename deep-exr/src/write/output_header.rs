//! The bytes of a written image before its chunks.

use std::collections::BTreeMap;

use super::options::WriteOptions;
use crate::attribute::Attribute;
use crate::channel::{Channel, ChannelType};
use crate::error::{Error, Result};
use crate::layout::Layout;
use crate::window::Window;

/// Longer names need a flag in the version field.
const SHORT_NAME: usize = 31;

/// All attributes but the one that is known at the end.
pub(super) struct OutputHeader {
    attributes: BTreeMap<Vec<u8>, Attribute>,
}

impl OutputHeader {
    pub(super) fn new(options: &WriteOptions) -> Result<Self> {
        let mut header = Self { attributes: options.attributes.clone() };
        let chunks = i32::try_from(options.grid()?.count())
            .map_err(|_| Error::Options("it has more than 2^31 chunks"))?;
        header.set("channels", "chlist", channel_list(&options.channels()));
        header.set("chunkCount", "int", chunks.to_le_bytes());
        header.set("compression", "compression", [options.compression.packing().id()]);
        header.set("lineOrder", "lineOrder", [0]);
        header.set("version", "int", 1_i32.to_le_bytes());
        let part_type = match options.layout {
            Layout::ScanLines => "deepscanline",
            Layout::Tiles { width, height } => {
                let [width, height] = [width, height].map(u32::to_le_bytes);
                header.set("tiles", "tiledesc", [&width[..], &height, &[0]].concat());
                "deeptile"
            }
        };
        header.set("type", "string", part_type);
        let data_window = options.data_window()?;
        header.set_window("dataWindow", data_window);
        header.set_window("displayWindow", options.display_window.unwrap_or(data_window));
        header.set_default(Attribute::string("name", "deep"));
        header.set_default(Attribute::floats("pixelAspectRatio", "float", &[1.0]));
        header.set_default(Attribute::floats("screenWindowCenter", "v2f", &[0.0; 2]));
        header.set_default(Attribute::floats("screenWindowWidth", "float", &[1.0]));
        Ok(header)
    }

    /// The file's first bytes, up to the offset table. Their number does not
    /// depend on `max_samples`.
    pub(super) fn bytes(&self, max_samples: u32) -> Vec<u8> {
        const VERSION: u32 = 2;
        const LONG_NAMES: u32 = 0x400;
        const DEEP: u32 = 0x800;
        let max_samples = i32::try_from(max_samples).unwrap_or(i32::MAX);
        let mut attributes = self.attributes.clone();
        let last = Attribute::new("maxSamplesPerPixel", "int", max_samples.to_le_bytes());
        attributes.insert(last.name.clone(), last);
        let is_long = |a: &Attribute| a.name.len().max(a.type_name.len()) > SHORT_NAME;
        let long_names = if attributes.values().any(is_long) { LONG_NAMES } else { 0 };
        let mut bytes = exr::meta::magic_number::BYTES.to_vec();
        bytes.extend((VERSION | DEEP | long_names).to_le_bytes());
        for Attribute { name, type_name, value } in attributes.values() {
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
        self.attributes.insert(name.into(), Attribute::new(name, type_name, value));
    }

    fn set_default(&mut self, attribute: Attribute) {
        self.attributes.entry(attribute.name.clone()).or_insert(attribute);
    }

    fn set_window(&mut self, name: &str, window: Window) {
        let numbers = [window.min, window.max].concat();
        self.set(name, "box2i", numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>());
    }
}

fn channel_list(channels: &[Channel]) -> Vec<u8> {
    let mut list = Vec::new();
    for channel in channels {
        let kind: i32 = match channel.channel_type {
            ChannelType::Uint => 0,
            ChannelType::Half => 1,
            ChannelType::Float => 2,
        };
        list.extend(channel.name.bytes());
        list.push(0);
        list.extend([kind, 0, 1, 1].iter().flat_map(|word| word.to_le_bytes()));
    }
    list.push(0);
    list
}
