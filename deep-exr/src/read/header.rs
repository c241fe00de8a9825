//! What a part's header says about its pixels.

use crate::attribute::Attribute;
use crate::channel::{AlphaChannels, Channel, ReadChannels};
use crate::layout::Layout;
use crate::window::Window;

/// Header of the part that is read.
///
/// ```no_run
/// use deep_exr::{DeepExrReader, Limits};
///
/// let reader = DeepExrReader::open("smoke.exr".as_ref(), None, &Limits::default())?;
/// let header = reader.header();
/// println!("{} x {}, {:?}", header.width, header.height, header.layout);
/// for attribute in &header.attributes {
///     println!("{}: {} bytes", attribute.name_text(), attribute.value.len());
/// }
/// # Ok::<(), deep_exr::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Header {
    /// Name of the part.
    pub part_name: Option<String>,
    /// The pixels that are stored. Row 0 of [`read_rows`] is its top row.
    ///
    /// [`read_rows`]: super::reader::DeepExrReader::read_rows
    pub data_window: Window,
    /// The pixels of the whole picture.
    pub display_window: Window,
    /// Width of the data window in pixels, at least 1.
    pub width: u32,
    /// Height of the data window in pixels, at least 1.
    pub height: u32,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// Centre of the screen window.
    pub screen_window_center: [f32; 2],
    /// Width of the screen window.
    pub screen_window_width: f32,
    /// True for a deep part; in a flat one each pixel is one sample.
    pub deep: bool,
    /// Scan lines or tiles.
    pub layout: Layout,
    /// True for the tiles of a mip- or rip-map, whose smaller levels are not
    /// read.
    pub has_levels: bool,
    /// Name of the compression, such as `ZIPS`.
    pub compression: &'static str,
    /// Channels that hold opacity.
    pub alpha: AlphaChannels,
    /// True if samples have a back depth.
    pub has_z_back: bool,
    /// All channels, in the file's order, with those that are not read.
    pub channels: Vec<Channel>,
    /// Names of those that are read.
    pub read: ReadChannels,
    /// Number of chunks whose places were not in the file's offset table and were
    /// found by looking through the file.
    pub found_chunks: u64,
    /// The number of samples of the fullest pixel as the header states it;
    /// `None` where it does not, or states −1 (unknown). Not relied upon.
    pub stated_max_samples: Option<u32>,
    /// `worldToCamera`, for row vectors, as in the file.
    pub world_to_camera: Option<[f32; 16]>,
    /// `worldToNDC`, for row vectors, as in the file.
    pub world_to_ndc: Option<[f32; 16]>,
    /// Every other attribute, in the file's order and byte for byte.
    pub attributes: Vec<Attribute>,
}
