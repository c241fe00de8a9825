//! The switches of `inspect`.

use std::path::PathBuf;

use clap::Args;

use super::values::{self, ImageFile, ImageFormat};
use crate::page::PageLimit;

const EXAMPLES: &str = "\
Examples:
  dsm-tools inspect map.dsm
  dsm-tools inspect map.dsm --pixel 14,11 --plot pixel.svg
  dsm-tools inspect map.dsm --slice 3.5 --image slice.png
  dsm-tools inspect map.dsm --html map.html";

/// Shows what a map or an image says of itself
///
/// Also one pixel's visibility function, as a list of vertices or as a plot,
/// the light that is left at one depth over the whole map, as an image, and
/// all of it as a page for a browser.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct InspectFlags {
    /// A shadow map of any kind (.dsm), or a deep or flat OpenEXR (.exr); - for standard input
    file: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// List the vertices of the pixel in column X and row Y
    #[arg(long, value_name = "X,Y", value_parser = values::pixel)]
    pixel: Option<[u32; 2]>,
    /// The mip level that the pixel is in
    #[arg(long, value_name = "L", requires = "pixel", default_value_t = 0)]
    level: u32,
    /// Plot that pixel's visibility function, as .svg or .png
    #[arg(long, value_name = "OUT", requires = "pixel")]
    #[arg(value_parser = values::image_file([ImageFormat::Svg, ImageFormat::Png]))]
    plot: Option<ImageFile>,
    /// Take the transmittance at depth Z, in scene units ...
    #[arg(long, value_name = "Z", requires = "image", allow_negative_numbers = true)]
    #[arg(value_parser = values::depth)]
    slice: Option<f32>,
    /// ... and write it as an image, .png (8 bits, sRGB) or .exr (linear)
    #[arg(long, value_name = "OUT", requires = "slice")]
    #[arg(value_parser = values::image_file([ImageFormat::Png, ImageFormat::Exr]))]
    image: Option<ImageFile>,
    /// Write a page of HTML that shows the map at any depth and the curve of any pixel; it
    /// is one file and asks for no other
    #[arg(long, value_name = "OUT", value_parser = values::html_file())]
    html: Option<PathBuf>,
    /// The most bytes of that page; of a map that is too large it shows the levels that
    /// fit, or its middle, and says so
    #[arg(long, value_name = "SIZE", requires = "html", default_value_t = PageLimit::DEFAULT)]
    max_size: PageLimit,
}

/// The light at a depth, and where to write it.
#[derive(Debug)]
pub(crate) struct SliceFile {
    pub(crate) depth: f32,
    pub(crate) image: ImageFile,
}

/// A checked `inspect`.
#[derive(Debug)]
pub(crate) struct Inspect {
    pub(crate) file: PathBuf,
    pub(crate) json: bool,
    pub(crate) pixel: Option<[u32; 2]>,
    pub(crate) level: u32,
    pub(crate) plot: Option<ImageFile>,
    pub(crate) slice: Option<SliceFile>,
    pub(crate) html: Option<PathBuf>,
    pub(crate) max_size: PageLimit,
}

impl From<InspectFlags> for Inspect {
    fn from(flags: InspectFlags) -> Self {
        let InspectFlags { file, json, pixel, level, plot, slice, image, html, max_size } = flags;
        let slice = slice.zip(image).map(|(depth, image)| SliceFile { depth, image });
        Self { file, json, pixel, level, plot, slice, html, max_size }
    }
}
