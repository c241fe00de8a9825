//! An open map of a kind that is known at run time.

use std::any::Any;
use std::fmt::Debug;

use dsm_core::Rgb;
use serde_json::Value;

use super::map_kind::MapKind;
use super::pixel_contents::PixelContents;
use super::reader::KindReader;
use super::summary::MapSummary;
use crate::any_deep_map::AnyDeepMap;
use crate::crop::Crop;
use crate::error::{Error, Result};
use crate::format::container::Container;
use crate::metadata::Metadata;
use crate::tile_id::TileRect;

/// An open map of any registered kind and number of channels: what can be done
/// with one without knowing what it holds. [`Kinds::open`](crate::kind::kinds::Kinds::open)
/// makes them, each a [`KindReader`] behind this trait.
pub trait ErasedMap: Any + Debug + Send + Sync {
    /// The name of its kind.
    fn kind(&self) -> &'static str;

    /// The kind's title in messages, with its article.
    fn title(&self) -> &'static str;

    /// The file's sections, levels and tiles.
    fn container(&self) -> &Container;

    /// The map's metadata ([`KindReader::metadata`]).
    fn metadata(&self) -> &Metadata;

    /// The part of a map that the file holds, if not a whole one.
    fn crop(&self) -> Option<Crop>;

    /// Width and height of the whole map, of a crop too.
    fn whole_size(&self) -> [u32; 2];

    /// The metadata that only maps of its kind have, as one JSON object.
    ///
    /// # Errors
    ///
    /// [`Error::Metadata`] for keys that are no JSON.
    fn keys(&self) -> Result<Value>;

    /// Everything that is wrong with the file ([`KindReader::verify`]).
    fn verify(&self) -> Vec<Error>;

    /// Counts of the contents of its tiles ([`KindReader::summary`]).
    ///
    /// # Errors
    ///
    /// What is wrong with a tile.
    fn summary(&self) -> Result<MapSummary>;

    /// The stored numbers of a pixel ([`KindReader::contents`]).
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchLevel`], [`Error::NoSuchPixel`] for one outside the level, or
    /// what is wrong with its tile.
    fn contents(&self, level: u32, pixel: [u32; 2]) -> Result<PixelContents>;

    /// The stored numbers of each pixel of a rectangle of a level, row by row
    /// ([`KindReader::contents_of`]).
    ///
    /// # Errors
    ///
    /// As [`Self::functions`], of any kind, and those of `visit`.
    fn contents_of(
        &self,
        level: u32,
        rect: TileRect,
        visit: &mut dyn FnMut(PixelContents) -> Result<()>,
    ) -> Result<()>;

    /// The visibility functions of a rectangle of a level, of kinds that have such
    /// ([`KindReader::functions`]).
    ///
    /// # Errors
    ///
    /// As [`Self::contents`]; [`Error::Limit`] for what is too large for memory.
    fn functions(&self, level: u32, rect: TileRect) -> Result<Option<AnyDeepMap>>;
}

impl dyn ErasedMap {
    /// The map as one of kind `K`, if it is.
    #[must_use]
    pub fn downcast_ref<K: MapKind>(&self) -> Option<&KindReader<K>> {
        (self as &dyn Any).downcast_ref()
    }

    /// The map as one of kind `K`.
    ///
    /// # Errors
    ///
    /// [`Error::Kind`] if it is of another kind.
    pub fn downcast<K: MapKind>(self: Box<Self>) -> Result<KindReader<K>> {
        let found = self.kind().to_owned();
        let any: Box<dyn Any> = self;
        let reader = any.downcast::<KindReader<K>>();
        reader.map(|reader| *reader).map_err(|_| Error::Kind { found, wanted: K::TITLE })
    }
}

impl<K: MapKind> ErasedMap for KindReader<K> {
    fn kind(&self) -> &'static str {
        K::NAME
    }

    fn title(&self) -> &'static str {
        K::TITLE
    }

    fn container(&self) -> &Container {
        self.container()
    }

    fn metadata(&self) -> &Metadata {
        self.metadata()
    }

    fn crop(&self) -> Option<Crop> {
        self.crop()
    }

    fn whole_size(&self) -> [u32; 2] {
        let whole = self.whole_metadata();
        [whole.width, whole.height]
    }

    fn keys(&self) -> Result<Value> {
        serde_json::to_value(self.keys()).map_err(Error::Json)
    }

    fn verify(&self) -> Vec<Error> {
        self.verify()
    }

    fn summary(&self) -> Result<MapSummary> {
        self.summary()
    }

    fn contents(&self, level: u32, pixel: [u32; 2]) -> Result<PixelContents> {
        if self.metadata().channels == 1 {
            self.contents::<f32>(level, pixel)
        } else {
            self.contents::<Rgb>(level, pixel)
        }
    }

    fn contents_of(
        &self,
        level: u32,
        rect: TileRect,
        visit: &mut dyn FnMut(PixelContents) -> Result<()>,
    ) -> Result<()> {
        if self.metadata().channels == 1 {
            self.contents_of::<f32>(level, rect, visit)
        } else {
            self.contents_of::<Rgb>(level, rect, visit)
        }
    }

    fn functions(&self, level: u32, rect: TileRect) -> Result<Option<AnyDeepMap>> {
        if !K::FUNCTIONS {
            return Ok(None);
        }
        Ok(Some(if self.metadata().channels == 1 {
            self.functions::<f32>(level, rect)?.into()
        } else {
            self.functions::<Rgb>(level, rect)?.into()
        }))
    }
}
