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
mod limits;
mod measured_pixels;
mod merge;
mod metadata;
mod pyramid;
mod reader;
mod region;
mod row_order;
mod source;
mod tile;
mod writer;

/// Deep OpenEXR images, whose types the options of an export and the readers
/// of [`MapSource`] are.
pub use deep_exr;

pub use achieved_error::AchievedError;
pub use any::{AnyCachedMap, AnyDeepMap};
pub use attribute::Attribute;
pub use bake::{BakeOptions, BakeReport, bake};
pub use cache::{
    CacheStatistics, CachedMap, CachedShadow, CachedTile, CursorPool, LookupCursor, TileCache,
};
pub use codec::tile_columns::{ColumnReader, TileColumn};
pub use codec::{Block, Codec, EncodedTile};
pub use convert::{
    ConvertOptions, ExportOptions, ExportReport, ImportReport, MapDifference, MapSource,
    WorstPixel, check_bound, compare, compare_levels, convert, export_deep_exr,
};
pub use crop::Crop;
pub use error::{Error, Place, Result};
pub use format::atomic_file::{check_output, replace_file};
pub use format::container::Container;
pub use format::directory::{TileDirectory, TileEntry};
pub use format::level::Level;
pub use format::section::SectionKind;
pub use format::tile_id::{TileId, TileRect};
pub use format::version::FORMAT_VERSION;
pub use format::write::ContainerWriter;
pub use limits::Limits;
pub use merge::{MergeReport, merge};
pub use metadata::Metadata;
pub use pyramid::{PixelFunctions, PyramidOptions, PyramidSource, SourceTile, build_pyramid, mip};
pub use reader::MapReader;
pub use row_order::{PixelBlock, RowOrder};
pub use source::{MappedFile, Memory, Source};
pub use tile::Tile;
pub use writer::{MapWriter, WriteOptions, write_map};
