//! A kind of map that no crate knows, in one file: it is written, opened by name,
//! verified, summed up, shown, cached and looked up.

use dsm_core::{MapInfo, Rgb, Transmittance, VisibilityField};
use dsm_io::detail::{
    EncodedTile, FieldKind, KindReader, KindWriter, Kinds, MapKind, MapTile, PixelValue, Result,
    StoredTile, TileCache, TileColumn, TileId,
};
use dsm_io::{
    AchievedError, Codec, Error, Limits, MapSummary, Metadata, Packing, PixelContents, WriteOptions,
};
use serde::{Deserialize, Serialize};

/// One wall a pixel, or none: what is behind it is as dark as the map says.
#[derive(Debug)]
struct Walls;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct WallKeys {
    darkness: f32,
}

/// The depth of each pixel's wall; 0: none.
#[derive(Clone, Debug, PartialEq)]
struct WallTile {
    size: [u32; 2],
    depths: Vec<f32>,
    darkness: f32,
}

impl MapTile for WallTile {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn bytes(&self) -> u64 {
        4 * self.depths.len() as u64
    }
}

impl MapKind for Walls {
    const NAME: &'static str = "org.example.walls";
    const TITLE: &'static str = "a map of walls";
    const VERSION: u32 = 2;

    type Keys = WallKeys;
    type Tile<T: Transmittance> = WallTile;

    fn check(_: &Metadata, keys: &WallKeys) -> Result<()> {
        if (0.0..=1.0).contains(&keys.darkness) {
            return Ok(());
        }
        Err(Error::Metadata("walls are between clear and black".to_owned()))
    }

    fn encode<T: Transmittance>(
        tile: &WallTile,
        _: Codec,
        packing: Packing,
    ) -> Result<EncodedTile> {
        let walls = || tile.depths.iter().copied().filter(|&depth| depth > 0.0);
        let Some(nearest) = walls().reduce(f32::min) else { return Ok(EncodedTile::default()) };
        let range = [nearest, walls().fold(0.0, f32::max)];
        let columns = [TileColumn::of_floats(&tile.depths)];
        EncodedTile::of_columns(&columns, walls().count() as u64, range, packing)
    }

    fn empty<T: Transmittance>(size: [u32; 2], keys: &WallKeys) -> Result<WallTile> {
        let depths = vec![0.0; size[0] as usize * size[1] as usize];
        Ok(WallTile { size, depths, darkness: keys.darkness })
    }

    fn decode<T: Transmittance>(stored: StoredTile<'_>, keys: &WallKeys) -> Result<WallTile> {
        let (size, count) = (stored.size(), stored.pixel_count());
        let mut columns = stored.columns()?;
        let depths = columns.take_floats(count)?;
        if depths.iter().any(|depth| !(0.0..f32::INFINITY).contains(depth)) {
            return Err(columns.refuse("a wall stands nowhere"));
        }
        let walls = || depths.iter().copied().filter(|&depth| depth > 0.0);
        let range = [walls().fold(f32::MAX, f32::min), walls().fold(0.0, f32::max)];
        columns.finish(range)?;
        Ok(WallTile { size, depths, darkness: keys.darkness })
    }

    fn summarize<T: Transmittance>(tile: &WallTile, summary: &mut MapSummary) {
        summary.add("walls", tile.depths.iter().filter(|&&depth| depth > 0.0).count() as u64);
    }

    fn contents<T: Transmittance>(tile: &WallTile, pixel: usize) -> PixelContents {
        let mut contents = PixelContents::new("wall", &["depth"]);
        if tile.depths[pixel] > 0.0 {
            contents.push([PixelValue::Number(tile.depths[pixel])]);
        }
        contents
    }
}

impl FieldKind for Walls {
    type View<'t, T: Transmittance> = &'t WallTile;

    fn view<T: Transmittance>(tile: &WallTile) -> &WallTile {
        tile
    }

    fn evaluate<T: Transmittance>(view: &WallTile, pixel: usize, depth: f32) -> T {
        let wall = view.depths[pixel];
        T::splat(if wall > 0.0 && wall <= depth { 1.0 - view.darkness } else { 1.0 })
    }
}

/// 5 × 3 pixels in tiles of 2 × 2: walls at odd pixels of the first two rows.
fn depth(x: u32, y: u32) -> f32 {
    if y < 2 && (x + y) % 2 == 1 { 1.0 + x as f32 } else { 0.0 }
}

fn write<T: Transmittance>(path: &std::path::Path, darkness: f32) -> Result<u64> {
    let metadata = Metadata::new(5, 3, T::CHANNELS as u8, MapInfo::default());
    let options = WriteOptions::default().with_tile_size(2).with_packing(Packing::Zstd);
    let keys = WallKeys { darkness };
    let mut writer = KindWriter::<Walls>::create(path, metadata, &keys, options)?;
    let level = writer.levels()[0];
    for (x, y) in [(0, 0), (1, 0), (2, 0)] {
        let rect = level.tile_rect(x, y).unwrap();
        let pixels = (0..rect.width * rect.height)
            .map(|pixel| depth(rect.x + pixel % rect.width, rect.y + pixel / rect.width));
        let size = [rect.width, rect.height];
        let tile = WallTile { size, depths: pixels.collect(), darkness };
        writer.write_tile::<T>(TileId::new(0, x, y), &tile, AchievedError::NONE)?;
    }
    writer.finish()
}

fn check<T: Transmittance>() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walls.dsm");
    let limits = Limits::default();
    write::<T>(&path, 0.75).unwrap();

    // By a program that only knows that there is such a kind.
    let refused = Kinds::default().open(&path, &limits).unwrap_err().to_string();
    assert!(refused.ends_with("kind \"org.example.walls\", not one that this program reads"));
    let map = Kinds::default().with::<Walls>().open(&path, &limits).unwrap();
    assert_eq!((map.kind(), map.metadata().channels), (Walls::NAME, T::CHANNELS as u8));
    assert_eq!(map.keys().unwrap()["darkness"], 0.75);
    assert!(map.verify().is_empty());
    assert_eq!(map.summary().unwrap().count("walls"), Some(5));
    let shown = map.contents(0, [3, 0]).unwrap();
    assert_eq!((shown.name(), shown.rows()), ("wall", &[vec![PixelValue::Number(4.0)]][..]));
    assert!(map.contents(0, [0, 2]).unwrap().rows().is_empty());
    assert!(map.contents(0, [5, 0]).is_err() && map.contents(1, [0, 0]).is_err());

    // By one that knows what walls are: beside a deep map's, one budget holds all.
    let reader = map.downcast::<Walls>().unwrap();
    let cache = TileCache::new(1 << 20);
    let cached = cache.insert::<T, _>(reader).unwrap();
    let cursor = cached.cursor();
    for (x, y) in (0..3).flat_map(|y| (0..5).map(move |x| (x, y))) {
        for at in [0.5, 2.0, 9.0] {
            let dark = depth(x, y) > 0.0 && depth(x, y) <= at;
            let expected = T::splat(if dark { 0.25 } else { 1.0 });
            assert_eq!(cursor.evaluate([x, y], at).unwrap(), expected, "({x}, {y}) {at}");
        }
    }
    let statistics = cache.statistics();
    assert_eq!((statistics.loads, statistics.bytes), (3, 4 * 10));
    assert_eq!(cached.tile(TileId::new(0, 0, 1)).unwrap().map(|tile| tile.bytes()), None);
}

#[test]
fn a_kind_of_somebody_elses_is_a_kind_like_others() {
    check::<f32>();
    check::<Rgb>();
}

#[test]
fn what_breaks_a_rule_of_the_kind_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walls.dsm");
    let refused = write::<f32>(&path, 1.5).unwrap_err().to_string();
    assert_eq!(refused, "metadata: walls are between clear and black");
    write::<f32>(&path, 0.5).unwrap();
    let mut forge = dsm_tests::forge::Forge(std::fs::read(&path).unwrap());
    forge.replace("\"darkness\":0.5", "\"darkness\":2.5");
    let refused = KindReader::<Walls>::from_bytes(forge.sign(), &Limits::default());
    assert!(refused.unwrap_err().to_string().contains("between clear and black"));
    let mut forge = dsm_tests::forge::Forge(std::fs::read(&path).unwrap());
    forge.replace("\"kind_version\":2", "\"kind_version\":3");
    let refused = KindReader::<Walls>::from_bytes(forge.sign(), &Limits::default()).unwrap_err();
    assert!(refused.to_string().contains("version 3 of kind \"org.example.walls\""), "{refused}");
}
