//! The `.dsm` file format, and what deep OpenEXR images have to do with it.
//!
//! A `.dsm` file holds a deep shadow map in tiles, in as many levels as it
//! has; `docs/format/dsm-1.md` is the format's definition. [`MapWriter`]
//! writes one, tile by tile, and [`MapReader`] reads it, in place where it
//! can; [`TileCache`] keeps the tiles of many maps at hand for lookups; [`mip`]
//! gives a map the levels of a pyramid. [`Container`] and [`ContainerWriter`] do
//! the same for maps of any kind: they know sections and tiles, not what those
//! mean.

mod achieved_error;
mod any;
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
mod measured_pixels;
mod merge;
mod metadata;
mod pyramid;
mod reader;
mod region;
mod row_order;
mod section_kind;
mod source;
mod tile;
mod tile_id;
mod worst_pixel;
mod writer;

/// Deep OpenEXR images, whose types the options of an export and the readers
/// of [`MapSource`] are.
pub use deep_exr;

pub use achieved_error::AchievedError;
pub use any::{AnyCachedMap, AnyDeepMap};
pub use attribute::Attribute;
pub use bake::{BakeOptions, BakeReport, bake};
pub use cache::TileCache;
pub use cache::cursor::LookupCursor;
pub use cache::map::CachedMap;
pub use cache::shadow::{CachedShadow, CursorPool};
pub use cache::statistics::CacheStatistics;
pub use cache::tile::CachedTile;
pub use codec::tile_columns::{ColumnReader, TileColumn};
pub use codec::{Block, Codec};
pub use convert::compare::{MapDifference, check_bound, compare, compare_levels};
pub use convert::export::{ExportReport, export_deep_exr};
pub use convert::export_options::ExportOptions;
pub use convert::report::ImportReport;
pub use convert::source::MapSource;
pub use convert::tiles::{ConvertOptions, convert};
pub use crop::Crop;
pub use error::{Error, Place, Result};
pub use format::atomic_file::replace_file;
pub use format::container::Container;
pub use format::directory::{TileDirectory, TileEntry};
pub use format::encoded_tile::EncodedTile;
pub use format::level::Level;
pub use format::write::ContainerWriter;
pub use kind::{
    Deep, DeepKeys, ErasedMap, FieldKind, KindReader, KindWriter, Kinds, MapKind, MapSummary,
    MapTile, PixelContents, PixelValue, StoredTile, SummaryValue,
};
pub use limits::Limits;
pub use merge::{MergeReport, merge};
pub use metadata::Metadata;
pub use pyramid::build::build_pyramid;
pub use pyramid::plan::PyramidOptions;
pub use pyramid::source::{PixelFunctions, PyramidSource, SourceTile};
pub use pyramid::stored::mip;
pub use reader::MapReader;
pub use row_order::RowOrder;
pub use section_kind::SectionKind;
pub use source::Source;
pub use source::mapped::MappedFile;
pub use source::memory::Memory;
pub use tile::Tile;
pub use tile_id::{TileId, TileRect};
pub use worst_pixel::WorstPixel;
pub use writer::{MapWriter, WriteOptions, write_map};
