//! Kinds of maps: what the container, the verifier, the cache and the program
//! have to know of one, and nothing else.
//!
//! [`MapKind`](map_kind::MapKind) says how tiles of a kind become bytes and come back. A file of a
//! kind known at compile time is a [`KindReader`](reader::KindReader); [`Kinds`](kinds::Kinds) opens files of any
//! kind that is registered as an [`ErasedMap`](erased_map::ErasedMap).

pub(crate) mod deep;
pub(crate) mod erased_map;
mod header;
pub(crate) mod kinds;
pub(crate) mod map_kind;
pub(crate) mod map_tiles;
pub(crate) mod pixel_contents;
pub(crate) mod reader;
pub(crate) mod summary;
pub(crate) mod writer;
