//! A file appears whole or not at all.

use std::path::Path;

use dsm_core::detail::PixelLists;
use dsm_io::detail::{MapWriter, TileId};
use dsm_io::{AchievedError, Limits, MapReader, Metadata, Packing, WriteOptions};

use crate::examples::{document, mono};

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn an_unfinished_map_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let old = document();
    old.write(&path).unwrap();
    let before = std::fs::read(&path).unwrap();

    let new = mono(Packing::Plain);
    let mut writer = MapWriter::create(&path, new.metadata.clone(), new.options).unwrap();
    let corner = PixelLists::<f32>::clear(8, 8);
    writer.write_tile(TileId::new(0, 0, 0), corner.view(), AchievedError::NONE).unwrap();
    assert_eq!(names(folder.path()).len(), 2, "the map and the one being written");
    drop(writer);

    assert_eq!(names(folder.path()), ["map.dsm"]);
    assert!(std::fs::read(&path).unwrap() == before);
}

#[test]
fn a_reader_keeps_the_map_that_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    document().write(&path).unwrap();
    let reader = MapReader::open(&path, &Limits::default()).unwrap();
    mono(Packing::Plain).write(&path).unwrap();
    assert!(reader.verify().is_empty());
    assert_eq!(reader.metadata().width, 3);
    assert_eq!(MapReader::open(&path, &Limits::default()).unwrap().metadata().width, 19);
    assert_eq!(names(folder.path()), ["map.dsm"]);
}

#[test]
fn only_regular_files_are_replaced_and_read() {
    let folder = tempfile::tempdir().unwrap();
    let metadata = Metadata::new(1, 1, 1, dsm_core::MapInfo::default());
    let nowhere = folder.path().join("no such folder").join("map.dsm");
    for path in [folder.path(), Path::new("/dev/null"), Path::new("/"), &nowhere] {
        let created = MapWriter::create(path, metadata.clone(), WriteOptions::default());
        let error = created.err().unwrap().to_string();
        assert!(error.starts_with(&path.display().to_string()), "{error}");
        assert!(MapReader::open(path, &Limits::default()).is_err());
        assert!(MapReader::open_in_memory(path, &Limits::default()).is_err());
    }
}

#[cfg(unix)]
#[test]
fn the_file_may_be_read_by_whom_the_mask_allows() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (map, plain) = (folder.path().join("map.dsm"), folder.path().join("plain"));
    document().write(&map).unwrap();
    std::fs::write(&plain, "").unwrap();
    let mode = |path: &Path| path.metadata().unwrap().permissions().mode();
    assert_eq!(mode(&map), mode(&plain));
}

#[test]
fn files_are_the_same_whenever_they_are_written() {
    assert!(mono(Packing::Zstd).bytes() == mono(Packing::Zstd).bytes());
}

#[cfg(unix)]
#[test]
fn a_replaced_file_keeps_its_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    for mode in [0o600, 0o444, 0o666, 0o640, 0o755] {
        drop(std::fs::remove_file(&path));
        std::fs::write(&path, "old").unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).unwrap();
        let example = document();
        let writer = MapWriter::create(&path, example.metadata, example.options).unwrap();
        // Not even while it is written may others read it who could not before.
        let partial = names(folder.path()).remove(0);
        assert!(partial.ends_with(".partial"), "{partial}");
        let mode_of = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o777;
        assert_eq!(mode_of(&folder.path().join(partial)) & !mode, 0, "{mode:o}");
        writer.finish().unwrap();
        assert_eq!(mode_of(&path), mode, "{mode:o}");
    }
}

#[cfg(unix)]
#[test]
fn a_symbolic_link_stays_and_what_it_leads_to_is_replaced() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::create_dir(path("versions")).unwrap();
    std::fs::write(path("versions/1.dsm"), "old").unwrap();
    symlink("versions/1.dsm", path("link.dsm")).unwrap();
    symlink("link.dsm", path("link of a link.dsm")).unwrap();
    symlink(path("versions/2.dsm"), path("to nothing yet.dsm")).unwrap();
    for (link, file) in
        [("link of a link.dsm", "versions/1.dsm"), ("to nothing yet.dsm", "versions/2.dsm")]
    {
        document().write(&path(link)).unwrap();
        assert!(path(link).symlink_metadata().unwrap().is_symlink());
        assert!(!path(file).symlink_metadata().unwrap().is_symlink());
        assert!(MapReader::open(path(file), &Limits::default()).unwrap().verify().is_empty());
    }
    assert_eq!(names(&path("versions")), ["1.dsm", "2.dsm"]);
    assert_eq!(names(folder.path()).len(), 4);

    symlink("b.dsm", path("a.dsm")).unwrap();
    symlink("a.dsm", path("b.dsm")).unwrap();
    symlink("/dev/null", path("null.dsm")).unwrap();
    symlink("no such folder/map.dsm", path("nowhere.dsm")).unwrap();
    for link in ["a.dsm", "null.dsm", "nowhere.dsm"] {
        let error = document().write(&path(link)).unwrap_err().to_string();
        assert!(error.starts_with(&path(link).display().to_string()), "{error}");
        assert!(path(link).symlink_metadata().unwrap().is_symlink());
    }
}
