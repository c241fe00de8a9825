//! Deep images by other programs come back as they were once they are written.

#![expect(clippy::print_stderr, reason = "a test that skips says so")]
#![expect(clippy::unwrap_used, reason = "a test that fails says where")]

use std::io::Cursor;
use std::path::{Path, PathBuf};

use deep_exr::{DeepExrReader, DeepExrWriter, Limits, WriteOptions};

/// Deep files by others, small ones and, where they are, real ones.
fn files_of_others() -> Vec<PathBuf> {
    let folders = ["tests/data", "../../shared/data/deep"].map(|folder| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        folder.read_dir().map_err(|_| eprintln!("skipped: no folder {}", folder.display()))
    });
    let entries = folders.into_iter().flatten().flatten().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|extension| extension == "exr")).collect()
}

#[test]
fn what_was_read_is_written_again() {
    let mut deep_files = 0;
    for path in files_of_others() {
        let Ok(mut original) = DeepExrReader::open(&path, None, &Limits::default()) else {
            continue;
        };
        let header = original.header().clone();
        if !header.deep {
            continue;
        }
        let rows = original.read_rows(0..header.height).unwrap();
        let options = WriteOptions::like(&header);
        let mut writer = DeepExrWriter::new(Cursor::new(Vec::new()), &options).unwrap();
        for y in 0..header.height {
            writer.write_rows(&original.read_rows(y..y + 1).unwrap()).unwrap();
        }
        let bytes = writer.finish().unwrap().into_inner();
        let mut copy = DeepExrReader::from_bytes(bytes, None, &Limits::default()).unwrap();
        assert_eq!(copy.read_rows(0..header.height).unwrap(), rows, "{}", path.display());
        let is = copy.header();
        assert_eq!(
            (is.data_window, is.display_window),
            (header.data_window, header.display_window)
        );
        assert_eq!((is.layout, is.compression), (header.layout, header.compression));
        assert_eq!((is.alpha, is.has_z_back), (header.alpha, header.has_z_back));
        assert_eq!(is.world_to_camera, header.world_to_camera);
        assert_eq!(is.world_to_ndc, header.world_to_ndc);
        let mut attributes = [&is.attributes, &header.attributes].map(Clone::clone);
        attributes.iter_mut().for_each(|list| list.sort_by(|a, b| a.name.cmp(&b.name)));
        assert_eq!(attributes[0], attributes[1], "{}", path.display());
        deep_files += 1;
    }
    assert!(deep_files >= 7, "{deep_files}");
}
