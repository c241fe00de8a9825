//! The `.dsm` file format, and what deep OpenEXR images have to do with it.
//!
//! A `.dsm` file holds a deep shadow map in tiles, in as many levels as it
//! has; `docs/format/dsm-1.md` is the format's definition. [`MapWriter`]
//! writes one, tile by tile, and [`MapReader`] reads it, in place where it
//! can; [`TileCache`] keeps the tiles of many maps at hand for lookups; [`mip`]
//! gives a map the levels of a pyramid. [`Container`] and [`detail::ContainerWriter`] do
//! the same for maps of any kind: they know sections and tiles, not what those
//! mean.

mod achieved_error;
mod any_cached_map;
mod any_deep_map;
mod attribute;
mod bake;
mod blocks;
mod cache;
mod codec;
mod columns;
mod convert;
mod crop;
mod error;
mod format;
mod kind;
mod limits;
mod map_tile;
mod measured_pixels;
mod merge;
mod metadata;
mod progress;
mod pyramid;
mod reader;
mod region;
mod row_order;
mod section_kind;
mod source;
mod tile;
mod tile_id;
mod worst_pixel;
mod write_options;
mod writer;

/// Deep OpenEXR images, whose types the options of an export and the readers
/// of [`MapSource`] are.
pub use deep_exr;

pub use any_deep_map::AnyDeepMap;
pub use attribute::Attribute;
pub use bake::{BakeOptions, BakeReport, bake};
pub use cache::TileCache;
pub use cache::map::CachedMap;
pub use cache::shadow::CachedShadow;
pub use cache::statistics::CacheStatistics;
pub use codec::{Block, Codec};
pub use convert::camera_reading::{CameraConventions, CameraReading, NdcRange, ViewAxis};
pub use convert::compare::{MapDifference, check_bound, compare, compare_levels};
pub use convert::export::{ExportReport, export_deep_exr};
pub use convert::export_options::ExportOptions;
pub use convert::report::ImportReport;
pub use convert::source::MapSource;
pub use convert::tiles::{ConvertOptions, convert};
pub use error::{Error, Place, Result};
pub use format::container::Container;
pub use format::level::Level;
pub use format::version::FORMAT_VERSION;
pub use kind::{Kinds, MapKind, MapSummary, PixelContents};
pub use limits::Limits;
pub use merge::{MergeReport, merge};
pub use metadata::Metadata;
pub use pyramid::plan::PyramidOptions;
pub use pyramid::stored::mip;
pub use reader::MapReader;
pub use source::Source;
pub use tile_id::TileRect;
pub use write_options::WriteOptions;
pub use writer::{MapWriter, write_map};

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::achieved_error::AchievedError;
    pub use crate::any_cached_map::AnyCachedMap;
    pub use crate::cache::cursor::LookupCursor;
    pub use crate::cache::shadow::CursorPool;
    pub use crate::cache::tile::CachedTile;
    pub use crate::codec::stored_tile::StoredTile;
    pub use crate::codec::tile_columns::{ColumnReader, TileColumn};
    pub use crate::crop::Crop;
    pub use crate::format::atomic_file::{check_output, replace_file};
    pub use crate::format::directory::{TileDirectory, TileEntry};
    pub use crate::format::encoded_tile::EncodedTile;
    pub use crate::format::write::ContainerWriter;
    pub use crate::kind::{
        Deep, DeepKeys, ErasedMap, FieldKind, KindReader, KindWriter, MapTiles, PixelValue,
        SummaryValue,
    };
    pub use crate::map_tile::MapTile;
    pub use crate::pyramid::build::build_pyramid;
    pub use crate::pyramid::source::{PixelFunctions, PyramidSource, SourceTile};
    pub use crate::row_order::RowOrder;
    pub use crate::section_kind::SectionKind;
    pub use crate::source::mapped::MappedFile;
    pub use crate::source::memory::Memory;
    pub use crate::tile::Tile;
    pub use crate::tile_id::TileId;
    pub use crate::worst_pixel::WorstPixel;
}
