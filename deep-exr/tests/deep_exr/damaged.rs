//! Good files, cut and altered: an error or an answer, never a panic.

use super::{read, read_in_bands, small};

const FILES: [&str; 8] = [
    "scan_zips_half.exr",
    "scan_none_float.exr",
    "scan_rle_opaque.exr",
    "tile_none_float.exr",
    "tile_zips_ids.exr",
    "parts.exr",
    "flat_zip.exr",
    "flat_tile_piz.exr",
];

#[test]
fn files_cut_at_every_length_are_errors() {
    for name in FILES {
        let bytes = small(name);
        let last = if name == "parts.exr" { bytes.len() * 3 / 4 } else { bytes.len() };
        for length in 0..last {
            let result = read(&bytes[..length]);
            // The parts behind the one that is read may be missing.
            assert!(result.is_err() || name == "parts.exr", "{name} cut to {length}");
        }
        assert!(read(&bytes).is_ok(), "{name}");
    }
}

#[test]
fn altered_bytes_never_panic() {
    let rounds = if dsm_testkit::is_long() { 200_000 } else { 3_000 };
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for name in FILES {
        let good = small(name);
        let mut errors = 0;
        for _ in 0..rounds {
            let mut bytes = good.clone();
            for _ in 0..1 + random(3) {
                let at = random(bytes.len());
                match random(3) {
                    0 => bytes[at] ^= 1 << random(8),
                    1 => bytes[at] = random(256) as u8,
                    _ => {
                        let end = bytes.len().min(at + 4);
                        bytes[at..end].copy_from_slice(&i32::MAX.to_le_bytes()[..end - at]);
                    }
                }
            }
            errors += usize::from(read_in_bands(&bytes, 2).is_err());
        }
        assert!(errors > rounds / 10, "{name}: {errors} errors in {rounds} rounds");
    }
}
