//! Reads layered maps.

use std::path::Path;

use dsm_core::{Rgb, SurfaceHit, Transmittance};
use dsm_io::{ColumnReader, Container, Error, Limits, Metadata, Place, Result, RowOrder, TileId};
use dsm_trace::LightFrame;
use shadow_maps::fragments::{Fragment, FragmentColumns, FragmentMap};

use super::fragments::FragmentTile;
use super::summary::LayeredSummary;
use super::tile::StoredTile;
use super::{LayeredKeys, LayeredKind};
use crate::depth_layers::{DepthLayers, MultilayerDepthMap};
use crate::layer::Layer;
use crate::layered_pixels::{LayeredPixels, LayeredPixelsBuilder};
use crate::multilayer_map::MultilayerMap;
use crate::multilayer_settings::{LayeredInfo, Layering};

/// An open layered map.
///
/// ```no_run
/// use dsm_io::Limits;
/// use mtsm::LayeredReader;
///
/// let reader = LayeredReader::open("fur.dsm", &Limits::default())?;
/// let map = reader.multilayer_map::<f32>()?;
/// println!("{} layers", map.pixels().layer_count());
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Debug)]
pub struct LayeredReader {
    container: Container,
    kind: LayeredKind,
    metadata: Metadata,
    layering: Layering,
    limits: Limits,
}

impl LayeredReader {
    /// Maps a file into memory; see [`Container::open`] for what that means if
    /// another process truncates the file.
    ///
    /// # Errors
    ///
    /// [`Error::File`], naming the file, with what is wrong with it.
    pub fn open(path: impl AsRef<Path>, limits: &Limits) -> Result<Self> {
        Container::open(path, limits).and_then(|container| Self::new(container, limits))
    }

    /// Opens the layered map that a container holds.
    ///
    /// # Errors
    ///
    /// [`Error::Kind`] if it holds another kind of map, and what is wrong with
    /// its metadata.
    pub fn new(container: Container, limits: &Limits) -> Result<Self> {
        let path = container.path().map(Path::to_owned);
        Self::check(container, limits).map_err(|error| error.in_file(path.as_deref()))
    }

    fn check(container: Container, limits: &Limits) -> Result<Self> {
        let found = container.kind()?;
        let Some(kind) = LayeredKind::from_name(&found) else {
            return Err(Error::Kind { found, wanted: "a map of layers" });
        };
        let json = container.metadata()?;
        let metadata = Metadata::from_json_of_any_kind(json)?;
        let LayeredKeys { layering, coverage } =
            serde_json::from_slice(json).map_err(Error::Json)?;
        if layering.max_layers == 0 || !(0.0..f32::INFINITY).contains(&layering.light_depth) {
            let reason = "a map allows at least one layer, and its light's depth is finite and ≥ 0";
            return Err(Error::Metadata(reason.to_owned()));
        }
        match (kind, coverage) {
            (LayeredKind::Fragments, Some(1 | 2 | 4 | 8)) => {}
            (LayeredKind::Fragments, _) => {
                let reason = "the coverage of fragments must be 1, 2, 4 or 8";
                return Err(Error::Metadata(reason.to_owned()));
            }
            (_, None) => {}
            (kind, Some(_)) => {
                let name = kind.name();
                let reason = format!("a map of kind \"{name}\" has no key \"coverage\"");
                return Err(Error::Metadata(reason));
            }
        }
        let level = container.level(0)?;
        let refuse =
            |reason: &'static str| Error::Invalid { place: Place::Level(0), reason: reason.into() };
        if [level.width, level.height] != [metadata.width, metadata.height]
            || [level.x, level.y] != [0, 0]
        {
            return Err(refuse("a layered map is stored whole"));
        }
        if container.levels().len() > 1 {
            return Err(refuse("a layered map has one level"));
        }
        Ok(Self { container, kind, metadata, layering, limits: limits.clone() })
    }

    /// The file's sections, levels and tiles.
    #[must_use]
    pub const fn container(&self) -> &Container {
        &self.container
    }

    /// The kind of map.
    #[must_use]
    pub const fn kind(&self) -> LayeredKind {
        self.kind
    }

    /// What the map says of itself.
    #[must_use]
    pub const fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// How its layers were chosen.
    #[must_use]
    pub const fn layering(&self) -> Layering {
        self.layering
    }

    /// What the map says of itself, as one in memory does.
    #[must_use]
    pub const fn info(&self) -> LayeredInfo {
        LayeredInfo { map: self.metadata.info, layering: self.layering }
    }

    fn read_tile<P: StoredTile>(&self, id: TileId) -> Result<P> {
        let (columns, rect) = ColumnReader::open(&self.container, id, &self.limits)?;
        let size = (rect.width, rect.height);
        match columns {
            None => P::empty(size, &self.layering),
            Some(columns) => P::decode(size, &self.layering, columns),
        }
    }

    /// Hands every tile of the map to `visit`, row by row.
    fn for_each_tile<P: StoredTile>(&self, mut visit: impl FnMut(P) -> Result<()>) -> Result<()> {
        if self.kind != P::KIND {
            let wanted = match P::KIND {
                LayeredKind::Mtsm => "a multilayer transparent shadow map",
                LayeredKind::Layers => "a multilayer depth map",
                LayeredKind::Fragments => "a map of fragments",
            };
            return Err(Error::Kind { found: self.kind.name().to_owned(), wanted });
        }
        let (channels, asked) = (self.metadata.channels, P::CHANNELS as u8);
        if channels != asked {
            return Err(Error::Channels { channels, asked });
        }
        let level = self.container.level(0)?;
        let (count, limit) = (level.pixel_count(), self.limits.max_pixels);
        if count > limit {
            return Err(Error::Limit { what: "pixels", count, limit });
        }
        let directory = self.container.directory(0)?;
        let lengths = directory.iter().map(|(_, entry)| entry.raw_length);
        let (count, limit) =
            (lengths.fold(0, u64::saturating_add), self.limits.max_in_memory_bytes);
        if count > limit {
            return Err(Error::Limit { what: "bytes of a map in memory", count, limit });
        }
        for (id, _) in directory.iter() {
            visit(self.read_tile(id)?)?;
        }
        Ok(())
    }

    fn in_file<V>(&self, read: Result<V>) -> Result<V> {
        read.map_err(|error| error.in_file(self.container.path()))
    }

    /// Tiles in a row.
    fn tile_columns(&self) -> usize {
        self.container.levels().first().map_or(0, |level| level.tiles()[0] as usize)
    }

    /// Reads a whole multilayer transparent shadow map into memory. O(layers).
    ///
    /// # Errors
    ///
    /// [`Error::Kind`] or [`Error::Channels`] for another map, or what is wrong
    /// with a tile.
    pub fn multilayer_map<T: Transmittance>(&self) -> Result<MultilayerMap<T>> {
        let Metadata { width, height, .. } = self.metadata;
        let mut pixels = LayeredPixelsBuilder::new(width, height);
        let mut rows = RowOrder::new(self.tile_columns());
        let read = self.for_each_tile(|tile: LayeredPixels<T>| {
            Ok(rows.push(tile, |tile, pixel| pixels.copy_pixel(tile, pixel))?)
        });
        self.in_file(read.and_then(|()| Ok(pixels.finish()?)))
            .map(|pixels| MultilayerMap::new(self.info(), pixels))
    }

    /// Reads a whole multilayer depth map into memory. O(layers).
    ///
    /// # Errors
    ///
    /// As [`Self::multilayer_map`].
    pub fn multilayer_depth_map<T: Transmittance>(&self) -> Result<MultilayerDepthMap<T>> {
        let Metadata { width, height, .. } = self.metadata;
        let mut pixels = DepthLayers::clear(width, height, self.layering.max_layers);
        let mut rows = RowOrder::new(self.tile_columns());
        let read = self.for_each_tile(|tile: DepthLayers<T>| {
            Ok(rows.push(tile, |tile, pixel| pixels.copy_pixel(tile, pixel))?)
        });
        self.in_file(read)?;
        Ok(MultilayerDepthMap::new(self.info(), pixels))
    }

    /// Reads a whole map of fragments into memory. O(fragments).
    ///
    /// # Errors
    ///
    /// As [`Self::multilayer_map`].
    pub fn fragment_map<T: Transmittance>(&self) -> Result<FragmentMap<T>> {
        let mut pixels = FragmentColumns::new();
        let mut rows = RowOrder::new(self.tile_columns());
        let read = self.for_each_tile(|tile: FragmentTile<T>| {
            Ok(rows.push(tile, |tile, pixel| pixels.push_pixel(tile.fragments(pixel)))?)
        });
        let camera = self.metadata.info.camera.unwrap_or_default();
        let size = [self.metadata.width, self.metadata.height];
        let map = read.and_then(|()| {
            let frame = LightFrame::new(&camera, size, self.layering.light_depth.into())?;
            Ok(FragmentMap::new(frame, pixels)?)
        });
        self.in_file(map)
    }

    /// What is in the way of one pixel: its runs of layers (depth, visibility,
    /// count), or of a map without runs one of depths, light left and counts
    /// of 1. Reads one tile.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchPixel`] for a pixel outside the map, or what is wrong with its
    /// tile.
    pub fn pixel_runs<T: Transmittance>(&self, [x, y]: [u32; 2]) -> Result<Vec<Vec<Layer<T>>>> {
        let level = self.container.level(0)?;
        if x >= level.width || y >= level.height {
            return Err(Error::NoSuchPixel([x, y]));
        }
        let id = TileId::new(0, x / level.tile_width, y / level.tile_height);
        let (_, rect) = self.container.entry(id)?;
        let pixel = (y - rect.y) as usize * rect.width as usize + (x - rect.x) as usize;
        let runs = match self.kind {
            LayeredKind::Mtsm => self.read_tile::<LayeredPixels<T>>(id).map(|tile| {
                tile.runs(pixel).map(|run| run.layers().collect()).collect::<Vec<Vec<_>>>()
            }),
            LayeredKind::Layers => self.read_tile::<DepthLayers<T>>(id).map(|tile| {
                let mut left = T::CLEAR;
                let layer = |SurfaceHit { depth, opacity }: SurfaceHit<T>| {
                    left = T::from_channels(|channel| {
                        left.channel(channel) * (1.0 - opacity.channel(channel))
                    });
                    Layer { depth, visibility: left, count: 1 }
                };
                let run: Vec<_> = tile.layers(pixel).map(layer).collect();
                if run.is_empty() { Vec::new() } else { vec![run] }
            }),
            LayeredKind::Fragments => self.read_tile::<FragmentTile<T>>(id).map(|tile| {
                let mut left = T::CLEAR;
                // The nearest first.
                let layer = |fragment: Fragment<T>| {
                    left = T::from_channels(|channel| {
                        left.channel(channel) * (1.0 - fragment.opacity.channel(channel))
                    });
                    Layer { depth: fragment.w.recip(), visibility: left, count: 1 }
                };
                let run: Vec<_> = tile.fragments(pixel).rev().map(layer).collect();
                if run.is_empty() { Vec::new() } else { vec![run] }
            }),
        };
        self.in_file(runs)
    }

    /// What all tiles hold together. O(layers).
    ///
    /// # Errors
    ///
    /// What is wrong with a tile.
    pub fn summary(&self) -> Result<LayeredSummary> {
        let summary = match (self.kind, self.metadata.channels) {
            (LayeredKind::Mtsm, 1) => self.sum_runs::<f32>(),
            (LayeredKind::Mtsm, _) => self.sum_runs::<Rgb>(),
            (LayeredKind::Layers, 1) => self.sum_layers::<f32>(),
            (LayeredKind::Layers, _) => self.sum_layers::<Rgb>(),
            (LayeredKind::Fragments, 1) => self.sum_fragments::<f32>(),
            (LayeredKind::Fragments, _) => self.sum_fragments::<Rgb>(),
        };
        self.in_file(summary)
    }

    fn sum_runs<T: Transmittance>(&self) -> Result<LayeredSummary> {
        let mut summary = LayeredSummary::default();
        self.for_each_tile(|tile: LayeredPixels<T>| {
            for pixel in 0..tile.pixel_count() {
                let layers = tile.runs(pixel).map(|run| run.len() as u64).sum();
                summary.add(tile.runs(pixel).len() as u64, layers);
            }
            summary.samples += tile.sample_count();
            Ok(())
        })?;
        Ok(summary)
    }

    fn sum_layers<T: Transmittance>(&self) -> Result<LayeredSummary> {
        let mut summary = LayeredSummary::default();
        self.for_each_tile(|tile: DepthLayers<T>| {
            for pixel in 0..tile.pixel_count() {
                let layers = tile.layers(pixel).len() as u64;
                summary.add(layers.min(1), layers);
            }
            summary.samples += tile.layer_count() as u64;
            Ok(())
        })?;
        Ok(summary)
    }

    fn sum_fragments<T: Transmittance>(&self) -> Result<LayeredSummary> {
        let mut summary = LayeredSummary::default();
        self.for_each_tile(|tile: FragmentTile<T>| {
            for pair in tile.columns.offsets.windows(2) {
                let layers = u64::from(pair[1] - pair[0]);
                summary.add(layers.min(1), layers);
            }
            summary.samples += tile.columns.w.len() as u64;
            Ok(())
        })?;
        Ok(summary)
    }

    /// Looks for everything that can be wrong with the file, as
    /// [`dsm_io::MapReader::verify`] does.
    #[must_use]
    pub fn verify(&self) -> Vec<Error> {
        let tolerance = self.metadata.info.tolerance.epsilon();
        self.container.verify(tolerance, |id| match (self.kind, self.metadata.channels) {
            (LayeredKind::Mtsm, 1) => self.read_tile::<LayeredPixels<f32>>(id).map(drop),
            (LayeredKind::Mtsm, _) => self.read_tile::<LayeredPixels<Rgb>>(id).map(drop),
            (LayeredKind::Layers, 1) => self.read_tile::<DepthLayers<f32>>(id).map(drop),
            (LayeredKind::Layers, _) => self.read_tile::<DepthLayers<Rgb>>(id).map(drop),
            (LayeredKind::Fragments, 1) => self.read_tile::<FragmentTile<f32>>(id).map(drop),
            (LayeredKind::Fragments, _) => self.read_tile::<FragmentTile<Rgb>>(id).map(drop),
        })
    }
}
