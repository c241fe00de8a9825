//! A bake that is broken off leaves nothing behind.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::Progress;
use dsm_io::detail::BakeOptions;
use dsm_io::{Error, PyramidOptions};

use crate::support::Stage;

fn names(folder: &Path) -> Vec<std::ffi::OsString> {
    std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect()
}

fn break_off(stage: &Stage, options: &BakeOptions, after: u64) {
    let settings = stage.settings([40, 40]).with_tile_size(8);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let watch = |progress: Progress| {
        assert_eq!(progress.total, 25);
        if progress.done >= after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let bake = || {
        dsm_io::detail::bake(&stage.baker::<f32>(&settings), &path, options, |_| (), watch)
            .unwrap_err()
    };
    let error = bake();
    assert!(matches!(error, Error::Interrupted), "{error}");
    assert!(names(folder.path()).is_empty(), "{:?}", names(folder.path()));

    std::fs::write(&path, "what was there").unwrap();
    let error = bake();
    assert!(matches!(error, Error::Interrupted), "{error}");
    assert_eq!(names(folder.path()), ["map.dsm"]);
    assert_eq!(std::fs::read(&path).unwrap(), b"what was there");
}

#[test]
fn an_interrupted_bake_leaves_no_file() {
    let stage = Stage::builtin("spinning-sphere");
    let pyramid = BakeOptions::default().with_pyramid(Some(PyramidOptions::default()));
    for after in [0, 1, 11] {
        break_off(&stage, &BakeOptions::default(), after);
        break_off(&stage, &pyramid, after);
    }
}
