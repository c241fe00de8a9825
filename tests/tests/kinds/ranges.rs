//! Files that are read range by range, as from an object store.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, Mutex};

use dsm_core::detail::InFile;
use dsm_core::{
    DeepMap, Filter, FilterShape, Footprint, MapInfo, PixelListsBuilder, Receiver, Vertex,
    filtered_lookup,
};
use dsm_io::detail::{Container, Result, Source, TileCache, TileId};
use dsm_io::{
    AchievedError, Error, Limits, MapReader, MapSource, Metadata, Packing, WriteOptions, write_map,
};

/// Hands out copies of ranges, keeps a list of them, and none longer than it may.
#[derive(Clone, Debug)]
struct Store {
    bytes: Arc<Vec<u8>>,
    most: u64,
    asked: Arc<Mutex<Vec<Range<u64>>>>,
    /// How many ranges had been asked for when the file was said to be open.
    opened: Arc<Mutex<Vec<usize>>>,
}

impl Store {
    fn new(bytes: Vec<u8>, most: u64) -> Self {
        Self { bytes: Arc::new(bytes), most, asked: Arc::default(), opened: Arc::default() }
    }

    /// What was asked for since the last time.
    fn asked(&self) -> Vec<Range<u64>> {
        std::mem::take(&mut self.asked.lock().unwrap())
    }

    fn open(&self) -> Result<MapReader> {
        let limits = Limits::default();
        MapReader::new(Container::from_source(self.clone(), &limits)?, &limits)
    }
}

impl Source for Store {
    fn length(&self) -> u64 {
        self.bytes.len() as u64
    }

    fn read(&self, range: Range<u64>) -> Result<Cow<'_, [u8]>> {
        if range.end - range.start > self.most {
            return Err(Error::Setting("that is too much at once".into()));
        }
        self.asked.lock().unwrap().push(range.clone());
        Ok(Cow::Owned(self.bytes[range.start as usize..range.end as usize].to_vec()))
    }

    fn opened(&self) {
        self.opened.lock().unwrap().push(self.asked.lock().unwrap().len());
    }

    fn remark(&self) -> Option<&str> {
        Some("a store of a test")
    }
}

/// 64 × 64 pixels in tiles of 8 × 8, each with a step and a ramp.
fn map() -> DeepMap<f32> {
    let mut pixels = PixelListsBuilder::<f32>::new(64, 64);
    for pixel in 0..64 * 64_u32 {
        let value = (pixel % 97) as f32 / 128.0;
        pixels.push(Vertex::new(1.0, 1.0));
        pixels.push(Vertex::new(1.0, value));
        pixels.push(Vertex::new(3.0 + (pixel % 5) as f32, value / 2.0));
        pixels.finish_pixel().unwrap();
    }
    DeepMap::new(MapInfo::default(), pixels.finish().unwrap())
}

fn file(packing: Packing) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let options = WriteOptions::default().with_tile_size(8).with_packing(packing);
    let metadata = Metadata::new(64, 64, 1, MapInfo::default());
    write_map(&path, metadata, &map(), AchievedError::NONE, options).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn opening_reads_what_stands_around_the_tiles() {
    for packing in [Packing::Plain, Packing::Zstd] {
        let store = Store::new(file(packing), u64::MAX);
        let reader = store.open().unwrap();
        let asked = store.asked();
        // Prologue, section table, levels, directory, metadata: one range each, and
        // nothing of a tile.
        assert_eq!(asked.len(), 5, "{asked:?}");
        assert_eq!(*store.opened.lock().unwrap(), [5]);
        assert_eq!(reader.container().remark(), Some("a store of a test"));
        let tiles = || reader.directory(0).unwrap().iter().map(|(_, entry)| *entry);
        for range in &asked {
            let touches = |offset: u64, length| offset < range.end && range.start < offset + length;
            assert!(tiles().all(|tile| !touches(tile.offset, tile.stored_length)), "{range:?}");
        }
        let read: u64 = asked.iter().map(|range| range.end - range.start).sum();
        assert!(read < reader.container().file_length() / 4);
        // A tile is one range, its own.
        reader.tile::<f32>(TileId::new(0, 3, 5)).unwrap();
        let entry = reader.directory(0).unwrap().get(3, 5).unwrap();
        let padded = entry.stored_length.next_multiple_of(64);
        let own = entry.offset..entry.offset + padded;
        assert_eq!(store.asked().as_slice(), std::slice::from_ref(&own));
    }
}

#[test]
fn lookups_read_the_tiles_that_they_touch() {
    let store = Store::new(file(Packing::Zstd), 1 << 14);
    let cache = TileCache::new(1 << 20);
    let cached = cache.insert::<f32, _>(store.open().unwrap()).unwrap();
    store.asked();
    let footprint = Footprint::Isotropic(Filter::new(FilterShape::Box, 4.0).unwrap());
    let receiver = Receiver::new([8.0, 16.0], 5.0);
    let light = filtered_lookup(&cached.cursor(), &receiver, &footprint).unwrap();
    assert_eq!(filtered_lookup(&map(), &receiver, &footprint), Ok(light));
    assert_eq!(store.asked().len(), 4, "where four tiles meet");
    // All of it, which is the same as from memory.
    let reader = store.open().unwrap();
    assert!(reader.verify().is_empty());
    assert_eq!(reader.read_map::<f32>(0).unwrap().pixels(), map().pixels());
}

#[test]
fn what_a_source_says_is_what_callers_hear() {
    // No range of more than 64 bytes: the prologue, and no further.
    let refused = Store::new(file(Packing::Plain), 64).open().unwrap_err();
    assert_eq!(refused.to_string(), "that is too much at once");

    /// Hands out less than it was asked for.
    #[derive(Debug)]
    struct Short(Vec<u8>);

    impl Source for Short {
        fn length(&self) -> u64 {
            self.0.len() as u64
        }

        fn read(&self, range: Range<u64>) -> Result<Cow<'_, [u8]>> {
            let end = range.end.min(range.start + 64);
            Ok(Cow::Borrowed(&self.0[range.start as usize..end as usize]))
        }
    }

    let refused = Container::from_source(Short(file(Packing::Plain)), &Limits::default());
    assert!(matches!(refused, Err(Error::Truncated { .. })), "{refused:?}");
}

#[test]
fn addresses_are_no_paths_and_their_secrets_are_not_shown() {
    let limits = Limits::default();
    for address in ["https://me:hidden@127.0.0.1:1/map.dsm", "s3://maps/map.dsm?sig=hidden"] {
        let metadata = Metadata::new(64, 64, 1, MapInfo::default());
        let (none, options) = (AchievedError::NONE, WriteOptions::default());
        for error in [
            MapReader::open(address, &limits).map(drop).unwrap_err(),
            MapReader::open_in_memory(address, &limits).map(drop).unwrap_err(),
            MapSource::open(address.as_ref(), None, &limits).map(drop).unwrap_err(),
            write_map(address, metadata, &map(), none, options).map(drop).unwrap_err(),
        ] {
            let shown = error.to_string();
            assert!(shown.contains("://") && shown.contains("map.dsm: "), "{shown}");
            assert!(!format!("{error:?} {shown}").contains("hidden"), "{shown}");
            let Error::File(InFile { error, .. }) = error else { panic!("{error}") };
            assert!(matches!(*error, Error::Remote(_)), "{error}");
        }
    }
    // One slash fewer is a folder of that name, where there is nothing.
    let error = MapReader::open("s3:/maps/map.dsm", &limits).unwrap_err();
    assert_eq!(error.to_string(), "s3:/maps/map.dsm: cannot open");
}
