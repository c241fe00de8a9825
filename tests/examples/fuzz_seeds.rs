//! Writes inputs for the fuzz targets to begin with: `fuzz_seeds FOLDER`.
//!
//! Small sound files, and their tiles and directories in the form that the
//! targets take them.

use std::error::Error;
use std::fs;
use std::path::Path;

use dsm_tests::forge::Forge;
use dsm_tests::fuzz::TARGETS;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("which folder?")?;
    let folder = Path::new(&folder);
    for (target, _) in TARGETS {
        fs::create_dir_all(folder.join(target))?;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for file in fs::read_dir(root.join("data/dsm-1"))? {
        let path = file?.path();
        if path.extension().is_some_and(|extension| extension == "dsm") {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let forge = Forge(fs::read(&path)?);
            fs::write(folder.join("header").join(&name), &forge.0)?;
            fs::write(folder.join("directory").join(&name), directory(&forge))?;
            fs::write(folder.join("tile").join(&name), tile(&forge))?;
        }
    }
    for file in fs::read_dir(root.join("data/dsm-1/golden"))? {
        let path = file?.path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let kinds = [
            "mtsm",
            "layers",
            "fragments_",
            "fragments-with-media",
            "prefiltered",
            "attenuation",
            "views",
        ];
        let kind = kinds.iter().position(|kind| name.starts_with(kind));
        if let Some(kind) = kind {
            let mut seed = tile(&Forge(fs::read(&path)?));
            seed.insert(3, kind as u8);
            fs::write(folder.join("layered").join(&name), seed)?;
        }
    }
    for file in fs::read_dir(root.join("../deep-exr/tests/data"))? {
        let path = file?.path();
        if path.extension().is_some_and(|extension| extension == "exr") {
            fs::copy(&path, folder.join("deep_exr").join(path.file_stem().unwrap_or_default()))?;
        }
    }
    for file in fs::read_dir(root.join("../dsm-scene/tests/data/volumes"))? {
        let path = file?.path();
        if path.extension().is_some_and(|extension| extension == "vdb") {
            fs::copy(&path, folder.join("vdb").join(path.file_stem().unwrap_or_default()))?;
        }
    }
    for kind in ["text", "binary", "packed"] {
        for file in fs::read_dir(root.join("../dsm-scene/tests/data/usd").join(kind))? {
            let path = file?.path();
            fs::copy(&path, folder.join("usd").join(path.file_name().unwrap_or_default()))?;
        }
    }
    Ok(())
}

fn coloured(forge: &Forge) -> u8 {
    let metadata = forge.section(b"META");
    u8::from(forge.0[metadata..].windows(12).any(|bytes| bytes == br#""channels":3"#))
}

/// Its first level, with entries that point at the target's two payloads.
fn directory(forge: &Forge) -> Vec<u8> {
    let (level, directory) = (forge.section(b"LEVL"), forge.section(b"TDIR"));
    let entries = (forge.u64(forge.section_entry(b"TDIR") + 16) / 64) as usize;
    let mut seed = vec![0, coloured(forge)];
    // Tiles of a pixel, as the payloads are.
    let mut record = Forge(forge.0[level..level + 64].to_vec());
    record.put(8, (entries as u32).to_le_bytes());
    record.put(12, 1_u32.to_le_bytes());
    record.put(24, 1_u32.to_le_bytes());
    record.put(28, 1_u32.to_le_bytes());
    seed.extend(record.0);
    for index in 0..entries {
        let at = directory + 64 * index;
        let mut entry = Forge(forge.0[at..at + 64].to_vec());
        if index < 2 {
            let length = if coloured(forge) == 1 { 52_u64 } else { 24 };
            entry.put(0, (64 * (index as u64 + 1)).to_le_bytes());
            entry.put(8, length.to_le_bytes());
            entry.put(16, length.to_le_bytes());
            entry.put(24, 2_u64.to_le_bytes());
            entry.put(32, 2.0_f32.to_le_bytes());
            entry.put(36, 2.0_f32.to_le_bytes());
            entry.put(57, [0, 0]);
        } else {
            entry.put(0, [0; 40]);
            entry.put(48, [0; 11]);
        }
        seed.extend(entry.0);
    }
    seed
}

/// Its first tile.
fn tile(forge: &Forge) -> Vec<u8> {
    let (level, entry) = (forge.section(b"LEVL"), forge.tile_entry(0));
    let side =
        |at: usize, tile: usize| forge.u32(level + at).min(forge.u32(level + tile)) as u8 - 1;
    let [block, differences] = [forge.0[entry + 57], forge.0[entry + 58]];
    let mut seed = vec![side(8, 24), side(12, 28), coloured(forge), block, differences, 0];
    for number in [forge.u64(entry + 16) as u32, forge.u64(entry + 24) as u32] {
        seed.extend(number.to_le_bytes());
    }
    seed.extend(&forge.0[entry + 32..entry + 40]);
    let (offset, length) = (forge.u64(entry) as usize, forge.u64(entry + 8) as usize);
    seed.extend(&forge.0[offset..offset + length]);
    seed
}
