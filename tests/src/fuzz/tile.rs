//! One tile of any bytes, in a file that is otherwise sound.

use dsm_core::{Rgb, Transmittance};
use dsm_io::detail::{EncodedTile, Tile, TileId};
use dsm_io::{Codec, MapReader, Packing};

use super::limits;
use crate::forge::{Assembly, Forge};

/// Takes `bytes` for a tile: width, height (1 to 32 each), channels, block and
/// codec (block + 3 · codec) and differences in a byte each; a byte whose lowest bit asks that the entry
/// should agree with a plain payload; unpacked length, vertices and range of
/// depths in 4 bytes each; the rest is the payload.
///
/// # Panics
///
/// If a tile that is accepted breaks the rules of visibility functions, or
/// cannot be written again.
pub fn tile(bytes: &[u8]) -> bool {
    let Some((&[width, height, channels, block, differences, agree], rest)) =
        bytes.split_first_chunk()
    else {
        return false;
    };
    let Some((fields, payload)) = rest.split_at_checked(16) else { return false };
    let (width, height) = (1 + u32::from(width % 32), 1 + u32::from(height % 32));
    let coloured = channels % 2 == 1;
    let fields = Forge(fields.to_vec());
    let mut entry = Forge(vec![0; 64]);
    entry.put(0, 64_u64.to_le_bytes());
    entry.put(8, (payload.len() as u64).to_le_bytes());
    entry.put(16, u64::from(fields.u32(0)).to_le_bytes());
    entry.put(24, u64::from(fields.u32(4)).to_le_bytes());
    entry.put(32, fields.u32(8).to_le_bytes());
    entry.put(36, fields.u32(12).to_le_bytes());
    entry.put(56, [block / 3 % 3]);
    entry.put(57, [block % 3]);
    if block % 3 != 0 {
        entry.put(58, [differences]);
    }
    if agree % 2 == 1 && block % 9 == 0 {
        agree_with(&mut entry, &Forge(payload.to_vec()), (width * height) as usize, coloured);
    }
    let channels = if coloured { 3 } else { 1 };
    let mut assembly = Assembly::new(&format!(
        r#"{{"kind":"deep","width":{width},"height":{height},"channels":{channels},"depth_kind":"planar","tolerance":0}}"#
    ));
    assembly.payloads.push(payload.to_vec());
    assembly.levels.push((Assembly::level(width, height, 32), entry.0));
    let Ok(reader) = MapReader::from_bytes(assembly.bytes(), &limits()) else { return false };
    if coloured { check::<Rgb>(&reader) } else { check::<f32>(&reader) }
}

/// Makes the entry say of a plain payload what is true of it, so that what
/// lies behind those checks is reached.
fn agree_with(entry: &mut Forge, payload: &Forge, pixels: usize, coloured: bool) {
    let words = payload.0.len() / 4;
    let tables = if coloured { 2 * (pixels + 1) + pixels.div_ceil(32) } else { pixels + 1 };
    if words < tables {
        return;
    }
    let vertices = payload.u32(4 * pixels) as usize;
    entry.put(16, payload.0.len().to_le_bytes());
    entry.put(24, (vertices as u64).to_le_bytes());
    let depths = (tables..words.min(tables.saturating_add(vertices)))
        .map(|word| f32::from_bits(payload.u32(4 * word)));
    let (least, most) =
        depths.fold((f32::MAX, 0.0), |(least, most), z: f32| (z.min(least), z.max(most)));
    entry.put(32, (least + 0.0).to_le_bytes());
    entry.put(36, most.to_le_bytes());
}

fn check<T: Transmittance>(reader: &MapReader) -> bool {
    let tile = reader.tile::<T>(TileId::new(0, 0, 0));
    assert_eq!(tile.is_ok(), reader.verify().is_empty(), "verify is of another opinion");
    let Ok(tile) = tile else { return false };
    for function in tile.view().functions() {
        let mut last: Option<(f32, T)> = None;
        let mut at_one_depth = 0;
        for vertex in function.vertices() {
            assert!(vertex.z.is_finite() && vertex.z >= 0.0);
            let (z, value) = last.unwrap_or((-1.0, T::CLEAR));
            at_one_depth = if vertex.z == z { at_one_depth + 1 } else { 1 };
            assert!(vertex.z >= z && at_one_depth <= 2);
            for channel in 0..T::CHANNELS {
                let (new, old) = (vertex.value.channel(channel), value.channel(channel));
                assert!(0.0 <= new && new <= old && (last.is_some() || new == 1.0));
            }
            last = Some((vertex.z, vertex.value));
        }
    }
    written_again(&tile);
    true
}

fn written_again<T: Transmittance>(tile: &Tile<'_, T>) {
    for codec in [Codec::Exact, Codec::Quantized] {
        for packing in [Packing::Plain, Packing::Zstd] {
            let encoded = EncodedTile::encode(tile.view(), codec, packing);
            assert!(encoded.is_ok(), "{:?}", encoded.err());
        }
    }
}
