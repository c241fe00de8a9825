//! What is written is read, bit for bit, from either source.

use dsm_core::detail::{PixelLists, PixelListsView};
use dsm_core::{DeepMap, MapInfo, Rgb, Transmittance};
use dsm_io::detail::{AnyDeepMap, Container, TileId};
use dsm_io::{AchievedError, Limits, MapReader, Metadata, Packing, WriteOptions, write_map};
use dsm_testkit::config;
use proptest::prelude::*;

use crate::pixels::pixel_lists_of;

/// Up to 9 × 9 pixels, many of them empty.
fn pixel_lists<T: Transmittance>() -> impl Strategy<Value = PixelLists<T>> {
    (1_u32..=9, 1_u32..=9).prop_flat_map(|(width, height)| pixel_lists_of(width, height))
}

/// All columns, bit for bit.
pub(crate) fn bits<T: Transmittance>(pixels: PixelListsView<'_, T>) -> [Vec<u32>; 4] {
    let bits = |column: &[f32]| column.iter().map(|value| value.to_bits()).collect();
    [
        pixels.starts().to_vec(),
        pixels.value_starts().to_vec(),
        bits(pixels.depths()),
        bits(pixels.values()),
    ]
}

fn check<T: Transmittance>(pixels: &PixelLists<T>, options: WriteOptions) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let (width, height) = (pixels.view().width(), pixels.view().height());
    let metadata = Metadata::new(width, height, T::CHANNELS as u8, MapInfo::default());
    let map = DeepMap::new(metadata.info, pixels.clone());
    let length = write_map(&path, metadata.clone(), &map, AchievedError::NONE, options).unwrap();
    assert_eq!(path.metadata().unwrap().len(), length);

    let limits = Limits::default();
    let file = MapReader::open(&path, &limits).unwrap();
    let mapped = Container::open_mapped(&path, &limits);
    let mapped = MapReader::new(mapped.unwrap(), &limits).unwrap();
    let memory = MapReader::open_in_memory(&path, &limits).unwrap();
    for reader in [&file, &mapped, &memory] {
        assert_eq!(reader.metadata(), &metadata);
        assert!(reader.verify().is_empty(), "{:?}", reader.verify());
        let read = reader.read_map::<T>(0).unwrap();
        assert_eq!(bits(read.pixels().view()), bits(pixels.view()));
        assert_eq!(AnyDeepMap::read(reader, 0).unwrap().channels(), T::CHANNELS as u8);
    }
    let [columns, rows] = mapped.levels()[0].tiles();
    assert_eq!(columns, width.div_ceil(options.tile_size));
    for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
        let id = TileId::new(0, x, y);
        let tile = mapped.tile::<T>(id).unwrap();
        for other in [&file, &memory] {
            assert_eq!(bits(tile.view()), bits(other.tile::<T>(id).unwrap().view()));
        }
        let rect = mapped.tile_rect(id).unwrap();
        assert_eq!([tile.view().width(), tile.view().height()], [rect.width, rect.height]);
        let corner = pixels.view().pixel(rect.x, rect.y);
        assert_eq!(tile.view().pixel(0, 0).depths(), corner.depths());
        assert_eq!(tile.view().pixel(0, 0).columns(), corner.columns());
    }
}

fn options() -> impl Strategy<Value = WriteOptions> {
    (1_u32..=10, prop_oneof![Just(Packing::Plain), Just(Packing::Zstd)]).prop_map(
        |(size, packing)| WriteOptions::default().with_tile_size(size).with_packing(packing),
    )
}

proptest! {
    #![proptest_config(config(0x0d5_f11e))]

    #[test]
    fn mono_maps(pixels in pixel_lists::<f32>(), options in options()) {
        check(&pixels, options);
    }

    #[test]
    fn coloured_maps(pixels in pixel_lists::<Rgb>(), options in options()) {
        check(&pixels, options);
    }
}
