//! Files whose tables of chunks are lost.

use deep_exr::{DeepExrReader, Error, Limits};

use super::assemble::{file, scan_part};
use super::small;

#[test]
fn what_is_not_in_the_file_is_not_found() {
    let (good, tables) = file(&[scan_part()]);
    let place = |line: usize| {
        let entry = tables[0] + 8 * line;
        u64::from_le_bytes(good[entry..entry + 8].try_into().unwrap()) as usize
    };
    let without_table = |length: usize| {
        let mut bytes = good[..length].to_vec();
        bytes[tables[0]..tables[0] + 24].fill(0);
        bytes
    };
    let rows = |bytes: &[u8]| {
        let mut reader = DeepExrReader::from_bytes(bytes.to_vec(), None, &Limits::default())?;
        let rows: Vec<_> = (0..3).map(|y| reader.read_rows(y..y + 1)).collect();
        Ok::<_, Error>((rows, reader.header().found_chunks))
    };
    // The last chunk is cut off.
    let (cut, found) = rows(&without_table(good.len() - 1)).unwrap();
    assert_eq!((cut.iter().filter(|row| row.is_ok()).count(), found), (2, 2));
    let error = cut[2].as_ref().unwrap_err();
    assert!(matches!(error, Error::Chunk { .. }) && error.to_string().contains("missing"));
    // Nothing is found after a chunk of a wrong size.
    let mut broken = without_table(good.len());
    broken[place(1) + 4..place(1) + 12].fill(0xff);
    let (broken, found) = rows(&broken).unwrap();
    assert_eq!((broken.iter().filter(|row| row.is_ok()).count(), found), (1, 1));
    // A line that the image does not have is passed over.
    let mut other = without_table(good.len());
    other[place(1)..place(1) + 4].copy_from_slice(&77_i32.to_le_bytes());
    let (other, found) = rows(&other).unwrap();
    assert_eq!((other.iter().filter(|row| row.is_ok()).count(), found), (2, 2));
}

#[test]
fn lost_tables_of_files_that_others_wrote_are_made_again() {
    for name in [
        "scan_zips_half.exr",
        "tile_none_float.exr",
        "tile_zips_ids.exr",
        "flat_zip.exr",
        "flat_tile_piz.exr",
        "parts.exr",
        "scan_zstd_half.exr",
    ] {
        let good = small(name);
        let open = |bytes: Vec<u8>| DeepExrReader::from_bytes(bytes, None, &Limits::default());
        let mut whole = open(good.clone()).unwrap();
        let height = whole.header().height;
        let wanted = whole.read_rows(0..height).unwrap();
        // The tables hold places in what follows them, the first of them the nearest.
        let number = |at: usize| u64::from_le_bytes(good[at..at + 8].try_into().unwrap()) as usize;
        let (table, first) = (8..good.len() - 8)
            .map(|at| (at, number(at)))
            .find(|&(at, first)| {
                at < first
                    && first < good.len()
                    && (first - at).is_multiple_of(8)
                    && (at..first).step_by(8).all(|at| (first..good.len()).contains(&number(at)))
            })
            .unwrap();
        let mut lost = good.clone();
        lost[table..first].fill(0);
        let mut lost = open(lost).unwrap();
        assert!(lost.header().found_chunks > 0, "{name}");
        assert!(lost.read_rows(0..height).unwrap() == wanted, "{name}");
    }
}
