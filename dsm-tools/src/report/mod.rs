//! What a report shows, and its page: HTML without scripts.

mod html;
mod picture;
mod plot;

use deepshadow::scene::detail::{Image, ImageDifference};
use serde_json::Value;

/// A report about a scene and maps, or about maps alone.
pub(crate) struct Report {
    pub(crate) title: String,
    /// What was done, in sentences.
    pub(crate) about: Vec<String>,
    pub(crate) maps: Vec<MapEntry>,
    pub(crate) reference: Option<Picture>,
    pub(crate) pictures: Vec<Picture>,
    /// Methods that made no picture, and why.
    pub(crate) left_out: Vec<(String, String)>,
    /// Whether times and memory are shown.
    pub(crate) times: bool,
}

/// A map of the report.
pub(crate) struct MapEntry {
    pub(crate) name: String,
    /// What `inspect --json` tells of it.
    pub(crate) summary: Value,
    pub(crate) bytes: u64,
    pub(crate) notes: Vec<String>,
    /// The light that is left behind everything, of kinds with visibility functions.
    pub(crate) slice: Option<Image>,
}

/// A picture by one method.
pub(crate) struct Picture {
    pub(crate) method: String,
    /// The map that it was made with, by its name in the report.
    pub(crate) map: Option<String>,
    pub(crate) image: Image,
    pub(crate) notes: Vec<String>,
    pub(crate) cost: Cost,
}

/// What a picture took.
#[derive(Clone, Copy, Default)]
pub(crate) struct Cost {
    /// Seconds to bake its map.
    pub(crate) bake_s: Option<f64>,
    /// Seconds to open the map and make it ready.
    pub(crate) open_s: f64,
    pub(crate) render_s: f64,
    /// The most memory that the program had meanwhile, in bytes, where the system tells.
    pub(crate) peak: Option<u64>,
}

impl Report {
    /// How far a picture is from the reference.
    fn difference(&self, picture: &Picture) -> Option<ImageDifference> {
        picture.image.difference(&self.reference.as_ref()?.image)
    }
}
