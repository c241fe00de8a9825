//! A tile of 64 × 64 pixels with nine vertices each: how fast it is encoded,
//! and read from a file in memory, checksum and invariants included. Bytes
//! are those of the tile once unpacked.

#![expect(clippy::unwrap_used, reason = "a benchmark may stop where a value is refused")]

use divan::Bencher;
use divan::counter::BytesCount;
use dsm_core::detail::PixelLists;
use dsm_core::{DeepMap, MapInfo, PixelListsBuilder, Rgb, Transmittance, Vertex};
use dsm_io::detail::{EncodedTile, TileId};
use dsm_io::{AchievedError, Codec, Limits, MapReader, Metadata, Packing, WriteOptions, write_map};

fn main() {
    divan::main();
}

const SIZE: u32 = 64;

/// Smooth layers with noise, as compressed hair has them: ramps, and a step
/// for every fourth vertex.
fn pixels<T: Transmittance>() -> PixelLists<T> {
    let mut state = 1_u32;
    let mut noise = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut lists = PixelListsBuilder::new(SIZE, SIZE);
    for y in 0..SIZE {
        for x in 0..SIZE {
            let mut z = 10.0 + (x + 2 * y) as f32 * 0.01;
            let mut value = T::CLEAR;
            lists.push(Vertex::new(z, value));
            for vertex in 1..9 {
                z += if vertex % 4 == 1 { 0.0 } else { 0.1 + 0.1 * noise() };
                value = T::from_channels(|channel| value.channel(channel) * (0.7 + 0.2 * noise()));
                lists.push(Vertex::new(z, value));
            }
            lists.finish_pixel().unwrap();
        }
    }
    lists.finish().unwrap()
}

fn encode<T: Transmittance>(bencher: Bencher<'_, '_>, packing: Packing) {
    let pixels = pixels::<T>();
    let raw = EncodedTile::encode(pixels.view(), Codec::Exact, packing).unwrap().raw_length;
    bencher
        .counter(BytesCount::new(raw))
        .bench_local(|| EncodedTile::encode(pixels.view(), Codec::Exact, packing).unwrap());
}

fn decode<T: Transmittance>(bencher: Bencher<'_, '_>, packing: Packing) {
    let pixels = pixels::<T>();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tile.dsm");
    let metadata = Metadata::new(SIZE, SIZE, T::CHANNELS as u8, MapInfo::default());
    let map = DeepMap::new(metadata.info, pixels);
    let options = WriteOptions::default().with_tile_size(SIZE).with_packing(packing);
    write_map(&path, metadata, &map, AchievedError::NONE, options).unwrap();
    let reader = MapReader::open(&path, &Limits::default()).unwrap();
    let entry = *reader.directory(0).unwrap().get(0, 0).unwrap();
    assert_eq!(entry.block, u8::from(packing == Packing::Zstd), "the tile is packed as asked");
    assert_eq!(&reader.read_map::<T>(0).unwrap(), &map, "the tile reads as it was written");
    bencher
        .counter(BytesCount::new(entry.raw_length))
        .bench_local(|| reader.tile::<T>(TileId::default()).unwrap().view().vertex_count());
}

#[divan::bench(args = [Packing::Plain, Packing::Zstd])]
fn encode_mono(bencher: Bencher<'_, '_>, packing: Packing) {
    encode::<f32>(bencher, packing);
}

#[divan::bench(args = [Packing::Plain, Packing::Zstd])]
fn encode_rgb(bencher: Bencher<'_, '_>, packing: Packing) {
    encode::<Rgb>(bencher, packing);
}

#[divan::bench(args = [Packing::Plain, Packing::Zstd])]
fn decode_mono(bencher: Bencher<'_, '_>, packing: Packing) {
    decode::<f32>(bencher, packing);
}

#[divan::bench(args = [Packing::Plain, Packing::Zstd])]
fn decode_rgb(bencher: Bencher<'_, '_>, packing: Packing) {
    decode::<Rgb>(bencher, packing);
}
