//! What is known of an image before its pixels are.

use std::collections::BTreeMap;

use super::compression::Compression;
use super::sample_type::SampleType;
use crate::attribute::Attribute;
use crate::channel::{AlphaChannels, Channel, ChannelType};
use crate::error::{Error, Result};
use crate::grid::ChunkGrid;
use crate::layout::Layout;
use crate::read::header::Header;
use crate::rows::DeepRows;
use crate::window::Window;

/// Size, channels, layout, compression and attributes of a written deep image.
///
/// ```
/// use deep_exr::{AlphaChannels, Attribute, Compression, Layout, SampleType, WriteOptions};
///
/// let mut options = WriteOptions::new(640, 480)
///     .alpha(AlphaChannels::Colour, SampleType::Half)
///     .layout(Layout::Tiles { width: 64, height: 64 })
///     .compression(Compression::Rle);
/// options.set(Attribute::string("owner", "lighting"))?;
/// let names: Vec<_> = options.channels().into_iter().map(|channel| channel.name).collect();
/// assert_eq!(names, ["A", "AB", "AG", "AR", "Z", "ZBack"]);
/// # Ok::<(), deep_exr::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct WriteOptions {
    size: [u32; 2],
    corner: [i32; 2],
    pub(super) display_window: Option<Window>,
    pub(super) layout: Layout,
    pub(super) compression: Compression,
    alpha: AlphaChannels,
    pub(super) sample_type: SampleType,
    z_back: bool,
    pub(super) attributes: BTreeMap<Vec<u8>, Attribute>,
}

impl WriteOptions {
    /// An image of this size in pixels: scan lines in ZIPS, with the channels
    /// `A`, `Z` and `ZBack` of 32-bit floats.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            size: [width, height],
            corner: [0; 2],
            display_window: None,
            layout: Layout::default(),
            compression: Compression::default(),
            alpha: AlphaChannels::Mono,
            sample_type: SampleType::default(),
            z_back: true,
            attributes: BTreeMap::new(),
        }
    }

    /// The image that a header tells of, as far as it is read: its windows,
    /// layout, opacities, depths, matrices and attributes. Rows of its reader
    /// fit into this image.
    #[must_use]
    pub fn like(header: &Header) -> Self {
        let is_half = |channel: &Channel| {
            channel.name.contains('A') && channel.channel_type == ChannelType::Half
        };
        let half = header.channels.iter().any(is_half);
        let sample_type = if half { SampleType::Half } else { SampleType::Float };
        let compression = match header.compression {
            "NONE" => Compression::None,
            "RLE" => Compression::Rle,
            "ZSTD" => Compression::Zstd,
            _ => Compression::Zips,
        };
        let mut options = Self::new(header.width, header.height)
            .corner(header.data_window.min)
            .display_window(header.display_window)
            .layout(header.layout)
            .compression(compression)
            .alpha(header.alpha, sample_type)
            .z_back(header.has_z_back);
        let own = [
            header.part_name.as_deref().map(|name| Attribute::string("name", name)),
            Some(Attribute::floats("pixelAspectRatio", "float", &[header.pixel_aspect])),
            Some(Attribute::floats("screenWindowCenter", "v2f", &header.screen_window_center)),
            Some(Attribute::floats("screenWindowWidth", "float", &[header.screen_window_width])),
            header.world_to_camera.map(|m| Attribute::floats("worldToCamera", "m44f", &m)),
            header.world_to_ndc.map(|m| Attribute::floats("worldToNDC", "m44f", &m)),
        ];
        for attribute in own.into_iter().flatten().chain(header.attributes.iter().cloned()) {
            // What no header should hold is not carried on.
            drop(options.set(attribute));
        }
        options
    }

    /// The upper left pixel of the data window. Default (0, 0).
    #[must_use]
    pub fn corner(mut self, corner: [i32; 2]) -> Self {
        self.corner = corner;
        self
    }

    /// The pixels of the whole picture. Default: the data window.
    #[must_use]
    pub fn display_window(mut self, window: Window) -> Self {
        self.display_window = Some(window);
        self
    }

    /// Scan lines, or tiles of 1 to 4096 pixels each way, without smaller
    /// levels.
    #[must_use]
    pub fn layout(mut self, layout: Layout) -> Self {
        self.layout = layout;
        self
    }

    /// Compression of the chunks. Default: ZIPS.
    #[must_use]
    pub fn compression(mut self, compression: Compression) -> Self {
        self.compression = compression;
        self
    }

    /// Opacities of the samples, and their storage format. Beside those of
    /// colours stands their mean, in `A`, for programs that know no other.
    #[must_use]
    pub fn alpha(mut self, alpha: AlphaChannels, sample_type: SampleType) -> Self {
        (self.alpha, self.sample_type) = (alpha, sample_type);
        self
    }

    /// Back depths of the samples, in `ZBack`. Default: yes.
    #[must_use]
    pub fn z_back(mut self, z_back: bool) -> Self {
        self.z_back = z_back;
        self
    }

    /// Sets an attribute, in the place of one of the same name. The part's
    /// `name`, `pixelAspectRatio`, `screenWindowCenter` and
    /// `screenWindowWidth` are set so, too.
    ///
    /// # Errors
    ///
    /// [`Error::Attribute`] if no header can hold it, or if it says how the
    /// file is built, as `channels` does.
    pub fn set(&mut self, attribute: Attribute) -> Result<()> {
        attribute.check_writable()?;
        self.attributes.insert(attribute.name.clone(), attribute);
        Ok(())
    }

    /// The channels, in the order in which the file has them.
    #[must_use]
    pub fn channels(&self) -> Vec<Channel> {
        let alphas: &[&str] = match self.alpha {
            AlphaChannels::None => &[],
            AlphaChannels::Mono => &["A"],
            AlphaChannels::Colour => &["A", "AB", "AG", "AR"],
        };
        let depths: &[&str] = if self.z_back { &["Z", "ZBack"] } else { &["Z"] };
        let channel =
            |name: &&str, channel_type| Channel { name: (*name).to_owned(), channel_type };
        let alphas = alphas.iter().map(|name| channel(name, self.sample_type.channel_type()));
        alphas.chain(depths.iter().map(|name| channel(name, ChannelType::Float))).collect()
    }

    /// Grid of the image's chunks.
    ///
    /// # Errors
    ///
    /// [`Error::Options`] if there are no pixels, or pixels beyond 2³⁰, or
    /// tiles of a size that is not allowed.
    pub fn grid(&self) -> Result<ChunkGrid> {
        let origin = self.data_window()?.min;
        match self.layout {
            Layout::ScanLines => Ok(ChunkGrid::new(self.size, [self.size[0], 1], false, origin)),
            Layout::Tiles { width: width @ 1..=4096, height: height @ 1..=4096 } => {
                Ok(ChunkGrid::new(self.size, [width, height], true, origin))
            }
            Layout::Tiles { .. } => Err(Error::Options("tiles must be 1 to 4096 pixels wide")),
        }
    }

    /// No pixels yet of rows that are so many pixels wide, with the columns of
    /// this image.
    #[must_use]
    pub fn rows(&self, width: u32) -> DeepRows {
        DeepRows::new(width, self.alpha, self.z_back)
    }

    /// Whether rows have this image's columns.
    pub(super) fn fits(&self, rows: &DeepRows) -> bool {
        rows.alpha_channels() == self.alpha && rows.z_back().is_some() == self.z_back
    }

    /// The pixels that are stored. Every file can hold what readers accept.
    pub(super) fn data_window(&self) -> Result<Window> {
        let far = [0, 1].map(|axis| {
            let far = i64::from(self.corner[axis]) + i64::from(self.size[axis]) - 1;
            i32::try_from(far).unwrap_or(i32::MAX)
        });
        let window = Window { min: self.corner, max: far };
        if window.is_valid() {
            Ok(window)
        } else if self.size.contains(&0) {
            Err(Error::Options("it has no pixels"))
        } else {
            Err(Error::Options("the pixels of an OpenEXR reach 2^30 at most"))
        }
    }
}
