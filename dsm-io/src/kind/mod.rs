//! Kinds of maps: what the container, the verifier, the cache and the program
//! have to know of one, and nothing else.
//!
//! [`MapKind`] says how tiles of a kind become bytes and come back. A file of a
//! kind known at compile time is a [`KindReader`]; [`Kinds`] opens files of any
//! kind that is registered as an [`ErasedMap`].

mod deep;
mod erased_map;
mod header;
mod kinds;
mod map_kind;
mod map_tiles;
mod pixel_contents;
mod reader;
mod summary;
mod writer;

pub use deep::{Deep, DeepKeys};
pub use erased_map::ErasedMap;
pub use kinds::Kinds;
pub use map_kind::{FieldKind, MapKind};
pub use map_tiles::MapTiles;
pub use pixel_contents::{PixelContents, PixelValue};
pub use reader::KindReader;
pub use summary::{MapSummary, SummaryValue};
pub use writer::KindWriter;
