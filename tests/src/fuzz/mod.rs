//! What is asked of readers for bytes of any kind: never a panic, a hang or
//! memory without limit, and what is accepted keeps its rules.
//!
//! Each target is a function of some bytes. `tests/fuzz` runs them under
//! libFuzzer, an ordinary test on the inputs that were worth keeping.

mod deep_exr;
mod directory;
mod header;
mod layered;
mod model;
mod tile;
mod vdb;

use dsm_core::Rgb;
use dsm_io::{Error, Limits, MapReader};

pub use deep_exr::deep_exr;
pub use directory::directory;
pub use header::header;
pub use layered::{layered, read_any_kind};
pub use model::{BETWEEN_FILES, gltf, hair, obj, ply, usd};
pub use tile::tile;
pub use vdb::vdb;

/// A function of any bytes: whether they were accepted.
pub type Target = fn(&[u8]) -> bool;

/// The targets by name.
pub const TARGETS: [(&str, Target); 11] = [
    ("header", header),
    ("directory", directory),
    ("tile", tile),
    ("layered", layered),
    ("deep_exr", deep_exr),
    ("vdb", vdb),
    ("gltf", gltf),
    ("obj", obj),
    ("ply", ply),
    ("usd", usd),
    ("hair", hair),
];

/// Limits under which nothing takes more than some megabytes.
#[must_use]
pub fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_pixels = 1 << 16;
    limits.max_chunk_bytes = 1 << 20;
    limits.images.max_pixels = limits.max_pixels;
    limits.images.max_chunk_bytes = limits.max_chunk_bytes;
    limits.images.max_answer_bytes = 1 << 24;
    limits.max_in_memory_bytes = 1 << 24;
    limits.max_tiles = 1 << 12;
    limits
}

/// Everything that a reader can be asked for; whether nothing was wrong.
///
/// # Panics
///
/// If a file that `verify` calls sound cannot be read.
pub fn read_everything(bytes: Vec<u8>) -> bool {
    let Ok(reader) = MapReader::from_bytes(bytes, &limits()) else { return false };
    let sound = reader.verify().is_empty();
    let count = reader.levels().len() as u32;
    for level in 0..=count.min(8) {
        let mono = reader.read_map::<f32>(level);
        let coloured = reader.read_map::<Rgb>(level);
        let exists = level < count;
        // A level may be larger than what `limits` allows in memory at once.
        let beyond = |error: Option<&Error>| matches!(error, Some(Error::Limit { .. }));
        let too_large = beyond(mono.as_ref().err()) || beyond(coloured.as_ref().err());
        let read = mono.is_ok() || coloured.is_ok();
        assert!(!sound || !exists || read || too_large, "level {level}: sound, but not read");
    }
    sound
}
