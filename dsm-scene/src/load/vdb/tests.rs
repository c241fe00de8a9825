//! Files made byte by byte.

use glam::{DVec3, IVec3};

use super::*;

fn parse_all(bytes: &[u8]) -> Result<Volume> {
    parse(bytes, None)
}

const ACTIVE_MASK: u32 = 2;
const ZIP: u32 = 1;
const BLOSC: u32 = 4;

/// A file of one leaf at the origin, where the first two voxels along z are
/// 1 and 2; where its parts begin is put into `places`.
fn file(compression: u32, places: &mut Vec<usize>) -> Vec<u8> {
    fn name(bytes: &mut Vec<u8>, text: &str) {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.as_bytes());
    }
    let packed = compression & (ZIP | BLOSC) != 0;
    let mut file = 0x5644_4220_u64.to_le_bytes().to_vec();
    [224_u32, 9, 0].iter().for_each(|word| file.extend(word.to_le_bytes()));
    file.push(1);
    file.extend([b'-'; 36]);
    [0_u32, 1].iter().for_each(|word| file.extend(word.to_le_bytes()));
    ["density", "Tree_float_5_4_3", ""].iter().for_each(|text| name(&mut file, text));
    let offsets = file.len();
    file.extend([0; 24]);
    let grid = file.len();
    [compression, 0].iter().for_each(|word| file.extend(word.to_le_bytes()));
    name(&mut file, "UniformScaleMap");
    (0..15).for_each(|_| file.extend(0.5_f64.to_le_bytes()));
    places.push(file.len());
    [1_u32, 0, 0, 1, 0, 0, 0].iter().for_each(|word| file.extend(word.to_le_bytes()));
    for voxels in [32_768, 4096] {
        let mut masks = vec![0; voxels / 4];
        masks[0] = 1;
        file.extend(masks);
        file.push(0);
        places.push(file.len());
        file.extend(vec![0; if packed { 8 } else { 0 }]);
    }
    let mut mask = [0; 64];
    mask[0] = 3;
    file.extend(mask);
    let blocks = file.len();
    file.extend(mask);
    file.push(0);
    places.push(file.len());
    if packed {
        file.extend((-8_i64).to_le_bytes());
    }
    [1.0_f32, 2.0].iter().for_each(|value| file.extend(value.to_le_bytes()));
    for (index, offset) in [grid, blocks, file.len()].into_iter().enumerate() {
        let at = offsets + 8 * index;
        file[at..at + 8].copy_from_slice(&(offset as u64).to_le_bytes());
    }
    file
}

#[test]
fn voxels_are_read_stored_in_each_way() {
    for compression in [ACTIVE_MASK, ACTIVE_MASK | ZIP, ACTIVE_MASK | BLOSC] {
        let volume = parse_all(&file(compression, &mut Vec::new())).unwrap();
        assert_eq!(volume.voxel_count(), 2);
        assert_eq!(volume.voxel(IVec3::new(0, 0, 1)), 2.0);
        assert_eq!(volume.voxel_size(), DVec3::splat(0.5));
    }
}

#[test]
fn no_length_is_believed() {
    for compression in [ACTIVE_MASK, ACTIVE_MASK | ZIP, ACTIVE_MASK | BLOSC] {
        let mut places = Vec::new();
        let whole = file(compression, &mut places);
        for length in 0..whole.len() {
            assert!(parse_all(&whole[..length]).is_err(), "{length} bytes");
        }
        if compression == ACTIVE_MASK {
            continue;
        }
        let leaf = places[3];
        for &place in &places[1..] {
            for value in [i64::MIN, i64::MAX, -(1 << 40), -9, -7, 1 << 40, 8, 16] {
                let mut broken = whole.clone();
                broken[place..place + 8].copy_from_slice(&value.to_le_bytes());
                assert!(place != leaf || parse_all(&broken).is_err(), "{value}");
                let _ = parse_all(&broken);
            }
        }
    }
    // A block whose own header says another length, unpacked or packed.
    for (unpacked, packed) in [(1_u32 << 30, 16_u32), (7, 16), (8, 1 << 30), (8, 15)] {
        let mut places = Vec::new();
        let mut broken = file(ACTIVE_MASK | BLOSC, &mut places);
        broken.truncate(places[3]);
        broken.extend(16_i64.to_le_bytes());
        for word in [0x0101_0102, unpacked, unpacked, packed] {
            broken.extend(word.to_le_bytes());
        }
        let error = parse_all(&broken).unwrap_err().to_string();
        assert!(error.contains("wrong length of a compressed block"), "{error}");
    }
}

#[test]
fn what_is_not_read_is_refused() {
    let mut places = Vec::new();
    let whole = file(ACTIVE_MASK, &mut places);
    let replaced = |from: &[u8], to: &[u8]| {
        let at = whole.windows(from.len()).position(|window| window == from).unwrap();
        let mut broken = whole.clone();
        broken[at..at + to.len()].copy_from_slice(to);
        parse_all(&broken).unwrap_err().to_string()
    };
    assert!(replaced(&224_u32.to_le_bytes(), &221_u32.to_le_bytes()).contains("version 221"));
    assert!(replaced(b"UniformScaleMap", b"UniformRollsMap").contains("UniformRollsMap"));
    assert!(replaced(b"Tree_float", b"Tree_vec3s").contains("Tree_vec3s"));
    let mut many = whole.clone();
    many[places[0]] = 2;
    assert!(parse_all(&many).unwrap_err().to_string().contains("several buffers"));
    let mut far = whole.clone();
    far[places[0] + 19] = 0x7f;
    assert!(parse_all(&far).unwrap_err().to_string().contains("beyond"));
}
