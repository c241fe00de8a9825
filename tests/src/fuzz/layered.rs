//! One tile of any bytes of a layered map, in a file that is otherwise sound.

use dsm_core::{Rgb, Transmittance};
use dsm_io::detail::{Container, ErasedMap, Kinds, MapKind, Memory};
use dsm_io::{Codec, Packing};
use mtsm::detail::{Layers, Mtsm};
use shadow_maps::detail::{
    Attenuation, FragmentColumns, FragmentTile, Fragments, MediaColumns, Prefiltered, Views,
};

use super::limits;
use crate::forge::{Assembly, Forge};

/// Kinds, and what their metadata have besides.
const KINDS: [(&str, &str); 7] = [
    (Mtsm::NAME, ""),
    (Layers::NAME, ""),
    (Fragments::NAME, r#","coverage":8"#),
    (Fragments::NAME, r#","coverage":8,"kind_version":2,"media":{"max_slabs":8}"#),
    (Prefiltered::NAME, FILTERING),
    (Attenuation::NAME, r#","light_samples":16,"depth_tolerance":1"#),
    (Views::NAME, r#","eyes":[[0.5,0,0]],"gap":4"#),
];

const FILTERING: &str =
    r#","filtering":{"epsilon":{"interval":0.6},"accumulate":"multiply","depth":"weighted"}"#;

/// Takes `bytes` for a tile: width, height (1 to 32 each), channels, kind, block
/// and differences in a byte each; a byte whose lowest bit asks that the entry
/// should agree with a plain payload; unpacked length, layers and range of depths
/// in 4 bytes each; the rest is the payload.
///
/// # Panics
///
/// If the parts of the program are of different opinions about a tile.
pub fn layered(bytes: &[u8]) -> bool {
    let Some((&[width, height, channels, kind, block, differences, agree], rest)) =
        bytes.split_first_chunk()
    else {
        return false;
    };
    let Some((fields, payload)) = rest.split_at_checked(16) else { return false };
    let (width, height) = (1 + u32::from(width % 32), 1 + u32::from(height % 32));
    let channels = if channels % 2 == 1 { 3 } else { 1 };
    let (kind, keys) = KINDS[usize::from(kind) % KINDS.len()];
    let has_media = keys.contains("media");
    let fields = Forge(fields.to_vec());
    let mut entry = Forge(vec![0; 64]);
    entry.put(0, 64_u64.to_le_bytes());
    entry.put(8, (payload.len() as u64).to_le_bytes());
    entry.put(16, u64::from(fields.u32(0)).to_le_bytes());
    entry.put(24, u64::from(fields.u32(4)).to_le_bytes());
    entry.put(32, fields.u32(8).to_le_bytes());
    entry.put(36, fields.u32(12).to_le_bytes());
    entry.put(57, [block % 3]);
    if block % 3 != 0 {
        entry.put(58, [differences]);
    }
    if agree % 2 == 1 && block % 3 == 0 {
        let words =
            payload.chunks_exact(4).map(|word| u32::from_le_bytes([0, 1, 2, 3].map(|at| word[at])));
        let kind = (kind, has_media);
        agree_with(&mut entry, &words.collect::<Vec<_>>(), (kind, [width, height], channels));
    }
    let mut assembly = Assembly::new(&format!(
        r#"{{"kind":"{kind}","width":{width},"height":{height},"channels":{channels},"depth_kind":"planar","tolerance":0,"layering":{{"resets":3,"max_layers":16,"light_depth":0.5}}{keys}}}"#
    ));
    assembly.payloads.push(payload.to_vec());
    assembly.levels.push((Assembly::level(width, height, 32), entry.0));
    read_any_kind(assembly.bytes())
}

/// Everything that any program can ask of a file of any kind; whether nothing was
/// wrong with it.
///
/// # Panics
///
/// If a file that `verify` calls sound cannot be shown, or the other way round.
pub fn read_any_kind(bytes: Vec<u8>) -> bool {
    let kinds =
        Kinds::default().with::<Mtsm>().with::<Layers>().with::<Fragments>().with::<Prefiltered>();
    let kinds = kinds.with::<Attenuation>().with::<Views>();
    let container = Container::from_source(Memory::from(bytes), &limits());
    let Ok(map) = container.and_then(|container| kinds.read(container, &limits())) else {
        return false;
    };
    let sound = map.verify().is_empty();
    let summary = map.summary();
    let shown = show(&*map);
    assert!(!sound || (summary.is_ok() && shown), "sound, but {summary:?}");
    sound
}

/// Shows a pixel of every tile; whether all could be.
fn show(map: &dyn ErasedMap) -> bool {
    let mut all = true;
    for (index, level) in (0..).zip(map.container().levels()) {
        let [columns, rows] = level.tiles();
        for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
            let Some(rect) = level.tile_rect(x, y) else { continue };
            let last = [rect.x + rect.width - 1, rect.y + rect.height - 1];
            let shown = map.contents(index, last);
            if let Ok(contents) = &shown {
                let rows: usize = contents.lists().map(<[_]>::len).sum();
                assert_eq!(rows, contents.rows().len());
            }
            all &= shown.is_ok();
        }
    }
    all
}

/// Makes the entry say of a plain payload what is true of it, so that what
/// lies behind those checks is reached.
fn agree_with(
    entry: &mut Forge,
    words: &[u32],
    ((kind, has_media), size, channels): ((&str, bool), [u32; 2], u32),
) {
    let pixels = (size[0] * size[1]) as usize;
    entry.put(16, (4 * words.len() as u64).to_le_bytes());
    let word = |at: usize| words.get(at).map_or(0, |&word| word as usize);
    let (count, depths) = match kind {
        Mtsm::NAME => {
            let runs = word(0).min(words.len());
            let tables = 1 + (pixels + 1) + (runs + 1);
            let coloured = if channels > 1 { runs + 1 + runs.div_ceil(32) } else { 0 };
            (word(tables - 1), tables + coloured)
        }
        // All pixels, of which those that see nothing are 0.
        Views::NAME => (words.iter().filter(|&&word| word > 0).count(), 0),
        _ if has_media => (word(pixels).saturating_add(word(2 * pixels + 1)), 0),
        _ => (word(pixels), pixels + 1),
    };
    entry.put(24, (count as u64).to_le_bytes());
    let range = if kind == Fragments::NAME {
        let range = if channels > 1 {
            range::<Rgb>(words, size, has_media)
        } else {
            range::<f32>(words, size, has_media)
        };
        range.unwrap_or_default()
    } else {
        let end = depths.saturating_add(count).min(words.len());
        let end = if kind == Views::NAME { words.len() } else { end };
        let depths = words.get(depths..end).unwrap_or_default();
        let is_none = |bits: u32| kind == Views::NAME && bits == 0;
        let depths = depths.iter().filter(|&&bits| !is_none(bits));
        let depths = depths.map(|&bits| f32::from_bits(bits));
        let is_inverse = [Prefiltered::NAME, Attenuation::NAME, Views::NAME].contains(&kind);
        let depths = depths.map(|z| if is_inverse { z.recip().min(f32::MAX) } else { z });
        depths.fold([f32::MAX, 0.0], |[least, most], z| [z.min(least), z.max(most)])
    };
    entry.put(32, (range[0] + 0.0).to_le_bytes());
    entry.put(36, range[1].to_le_bytes());
}

/// The depths of the fragments in these columns, and of media, if they are such.
fn range<T: Transmittance>(words: &[u32], size: [u32; 2], has_media: bool) -> Option<[f32; 2]> {
    let pixels = (size[0] * size[1]) as usize;
    let mut rest = words;
    let mut take = |count: usize| {
        let (column, after) = rest.split_at_checked(count)?;
        rest = after;
        Some(column.to_vec())
    };
    let floats = |bits: Vec<u32>| bits.into_iter().map(f32::from_bits).collect::<Vec<_>>();
    let values = |channels: Vec<f32>| {
        let count = channels.len() / T::CHANNELS;
        let value = |at| T::from_channels(|channel| channels[channel * count + at]);
        (0..count).map(value).collect()
    };
    let offsets = take(pixels + 1)?;
    let of_media = if has_media { Some(take(pixels + 1)?) } else { None };
    let count = *offsets.last()? as usize;
    let w = floats(take(count)?);
    let gradients = [floats(take(count)?), floats(take(count)?)];
    let facing = take(count.div_ceil(32))?;
    let opacities = values(floats(take(count.checked_mul(T::CHANNELS)?)?));
    let [low, high] = [take(count)?, take(count)?];
    let coverage = low.iter().zip(high).map(|(&low, high)| u64::from(high) << 32 | u64::from(low));
    let coverage = coverage.collect();
    let columns = FragmentColumns { offsets, w, gradients, facing, opacities, coverage };
    let mut tile = FragmentTile::new(size, columns).ok()?;
    if let Some(offsets) = of_media {
        let borders = *offsets.last()? as usize;
        let depths = floats(take(borders)?);
        let thickness = values(floats(take(borders.checked_mul(T::CHANNELS)?)?));
        tile = tile.with_media(MediaColumns { offsets, depths, thickness }).ok()?;
    }
    let encoded = Fragments::encode(&tile, Codec::Exact, Packing::Plain).ok()?;
    Some([encoded.z_min, encoded.z_max])
}
