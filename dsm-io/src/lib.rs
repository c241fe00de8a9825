//! The `.dsm` file format, and what deep OpenEXR images have to do with it.
//!
//! A `.dsm` file holds a deep shadow map in tiles, in as many levels as it
//! has; `docs/format/dsm-1.md` is the format's definition. [`write_map`]
//! writes one and [`MapReader`] reads it, in place where it can; [`mip`] gives a
//! map the levels of a pyramid; [`convert()`] makes one of a deep image, and
//! [`export_deep_exr`] an image of one.

mod achieved_error;
mod any_cached_map;
mod any_deep_map;
mod attribute;
mod bake;
mod bake_to_size;
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
mod metadata_text;
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

/// Files in object stores, whose options a reader may set.
pub use dsm_remote;

/// Deep OpenEXR images, whose types the options of an export and the readers
/// of [`MapSource`] are.
pub use deep_exr;

pub use achieved_error::AchievedError;
pub use attribute::Attribute;
pub use codec::{Codec, Packing};
pub use convert::export::{ExportReport, export_deep_exr};
pub use convert::target_size::convert_to_size;
pub use convert::tiles::{ConvertOptions, convert};
pub use convert::{export_options::ExportOptions, report::ImportReport, source::MapSource};
pub use error::Error;
pub use kind::{pixel_contents::PixelContents, summary::MapSummary};
pub use limits::Limits;
pub use merge::{MergeReport, merge};
pub use metadata::Metadata;
pub use pyramid::{plan::PyramidOptions, stored::mip};
pub use reader::MapReader;
pub use write_options::WriteOptions;
pub use writer::write_map;

/// Parts that the other crates of this family stand on. They may change with any
/// version.
#[doc(hidden)]
pub mod detail {
    pub use crate::{
        any_cached_map::AnyCachedMap,
        any_deep_map::AnyDeepMap,
        bake::{BakeOptions, BakeReport, bake},
        bake_to_size::bake_to_size,
        cache::{
            TileCache,
            cursor::LookupCursor,
            map::CachedMap,
            shadow::{CachedShadow, CursorPool},
            statistics::CacheStatistics,
            tile::CachedTile,
        },
        codec::{
            stored_tile::StoredTile,
            tile_columns::{ColumnReader, TileColumn},
        },
        convert::{
            camera_reading::{CameraConventions, CameraReading, NdcRange, ViewAxis},
            compare::{MapDifference, check_bound, compare, compare_levels},
        },
        crop::Crop,
        error::{Place, Result},
        format::{
            atomic_file::{AtomicFile, check_output, replace_file},
            container::Container,
            directory::{TileDirectory, TileEntry},
            encoded_tile::EncodedTile,
            level::Level,
            version::FORMAT_VERSION,
            write::ContainerWriter,
        },
        kind::{
            deep::{Deep, DeepKeys},
            erased_map::ErasedMap,
            kinds::Kinds,
            map_kind::{FieldKind, MapKind},
            map_tiles::MapTiles,
            pixel_contents::PixelValue,
            reader::KindReader,
            summary::SummaryValue,
            writer::KindWriter,
        },
        map_tile::MapTile,
        merge::assemble::assemble,
        pyramid::{
            build::build_pyramid,
            source::{PixelFunctions, PyramidSource, SourceTile},
        },
        row_order::RowOrder,
        section_kind::SectionKind,
        source::{
            Source, file_length, mapped::MappedFile, memory::Memory, ranges::FileRanges,
            remote::RemoteSource,
        },
        tile::Tile,
        tile_id::{TileId, TileRect},
        worst_pixel::WorstPixel,
        writer::MapWriter,
    };
}
