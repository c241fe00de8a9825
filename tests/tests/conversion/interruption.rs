//! Long work that is broken off ends with an error and leaves no file.

use std::fs;
use std::ops::ControlFlow;

use dsm_core::Progress;
use dsm_io::detail::compare_levels;
use dsm_io::{
    ConvertOptions, Error, ExportOptions, Limits, MapReader, PyramidOptions, convert,
    export_deep_exr, merge, mip,
};

use crate::{converted, image, open, options};

const IMAGE: &str = "scan_zips_half.exr";

#[test]
fn what_is_broken_off_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let map = converted(&image(IMAGE), folder.path(), &options(0.0, 2));
    let reader = || MapReader::open(&map, &Limits::default()).unwrap();
    let output = at("output.dsm");
    fs::write(&output, b"before").unwrap();

    // In the middle, and at once.
    for stop in [0, 2] {
        let watch = || {
            let mut told = 0;
            move |progress: Progress| {
                assert!(progress.done <= progress.total && progress.total > 0);
                told += 1;
                if told > stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            }
        };
        let maps = [reader(), reader()];
        let pyramid = PyramidOptions::default();
        let outcomes = [
            convert(&mut open(&map), &output, &ConvertOptions::default(), watch()).err(),
            export_deep_exr(&mut open(&map), &output, &ExportOptions::default(), watch()).err(),
            merge(&maps, &output, None, watch()).err(),
            mip(&reader(), &output, &pyramid, watch()).err(),
            compare_levels(&mut open(&map), &mut open(&image(IMAGE)), watch()).err(),
        ];
        for (work, outcome) in outcomes.iter().enumerate() {
            let is_interrupted = matches!(outcome, Some(Error::Interrupted));
            // What has less steps than that is done before.
            assert!(is_interrupted || (stop > 0 && outcome.is_none()), "{work}: {outcome:?}");
        }
        if stop == 0 {
            assert_eq!(fs::read(&output).unwrap(), b"before");
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no partial file");
        }
    }
}
