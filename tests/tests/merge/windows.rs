//! Data windows of one picture, as a render in stripes or tiles leaves them.

use std::fs::File;
use std::path::{Path, PathBuf};

use deep_exr::{DeepExrWriter, DeepSample, Window};
use dsm_core::detail::{PixelLists, PixelWindow};
use dsm_core::{Progress, Rgb, Tolerance};
use dsm_io::{ConvertOptions, MergeReport, WriteOptions, convert};

use super::{merge, open, refusal, source};

/// The picture's pixels that are rendered.
const WHOLE: [i32; 4] = [-3, 2, 27, 24];

/// Writes the samples of these pixels as an image of its own, and converts it.
fn part(folder: &Path, [left, top, right, bottom]: [i32; 4], tile: u32) -> PathBuf {
    let size = [(right - left + 1) as u32, (bottom - top + 1) as u32];
    let options = deep_exr::WriteOptions::new(size[0], size[1])
        .corner([left, top])
        .display_window(Window { min: [0, 0], max: [31, 31] });
    let mut rows = options.rows(size[0]);
    for (y, x) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (y, x))) {
        // As many samples as the place says, of an opacity that it says too.
        for sample in 0..(x + 2 * y).rem_euclid(4) {
            let z = (10 + x + 40 * sample) as f32;
            let alpha = [(1 + (y * 31 + x).rem_euclid(97)) as f32 / 100.0; 3];
            rows.push(DeepSample { z, z_back: z + (y % 2) as f32, alpha });
        }
        rows.finish_pixel().unwrap();
    }
    let name = format!("{left} {top} {right} {bottom}");
    let image = folder.join(format!("{name}.exr"));
    let mut writer = DeepExrWriter::new(File::create(&image).unwrap(), &options).unwrap();
    writer.write_rows(&rows).unwrap();
    writer.finish().unwrap();
    let map = folder.join(format!("{name}.dsm"));
    let defaults = ConvertOptions::default();
    let options = ConvertOptions { write: defaults.write.with_tile_size(tile), ..defaults };
    convert(&mut source(&image), &map, &options, Progress::ignore).unwrap();
    map
}

#[test]
fn stripes_and_tiles_are_the_picture_that_was_rendered_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("merged.dsm");
    let [left, top, right, bottom] = WHOLE;
    let whole = open(&part(folder.path(), WHOLE, 8)).read_map::<f32>(0).unwrap();
    let stripes = vec![[left, top, right, 9], [left, 10, right, 11], [left, 12, right, bottom]];
    let tiles = vec![
        [left, top, 4, 13],
        [5, top, right, 6],
        [5, 7, right, 13],
        [left, 14, 20, bottom],
        [21, 14, right, bottom],
    ];
    // Two of one size are no maps of the same pixels.
    let halves = vec![[left, top, 11, bottom], [12, top, 26, bottom], [27, top, 27, bottom]];
    for windows in [stripes, tiles, halves] {
        for size in [8, 5, 64] {
            let parts = windows.iter().map(|&window| open(&part(folder.path(), window, size)));
            let mut parts: Vec<_> = parts.collect();
            parts.rotate_left(1);
            assert_eq!(merge(&parts, &output, 0.0), MergeReport::Assembled);
            let merged = open(&output);
            assert_eq!(merged.read_map::<f32>(0).unwrap(), whole, "{windows:?} {size}");
            assert_eq!(merged.levels()[0].tile_width, size);
        }
    }
}

#[test]
fn pixels_that_no_part_has_are_clear() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("merged.dsm");
    let corners = [[0, 0, 7, 7], [24, 24, 31, 31]];
    let parts = corners.map(|window| open(&part(folder.path(), window, 16)));
    assert_eq!(merge(&parts, &output, 0.0), MergeReport::Assembled);
    let map = open(&output).read_map::<f32>(0).unwrap();
    let window = PixelWindow { min: [0, 0], max: [31, 31] };
    assert_eq!(map.info().data_window, Some(window));
    for (corner, [left, top, ..]) in parts.iter().zip(corners) {
        let own = corner.read_map::<f32>(0).unwrap();
        for (y, x) in (0..8).flat_map(|y| (0..8).map(move |x| (y, x))) {
            let merged = map.pixel(left as u32 + x, top as u32 + y);
            assert_eq!(merged.depths(), own.pixel(x, y).depths());
        }
    }
    assert!((0..32).all(|y| (8..24).all(|x| map.pixel(x, y).is_empty())));
}

#[test]
fn what_is_no_part_is_refused_as_before() {
    let folder = tempfile::tempdir().unwrap();
    let paths =
        [[0, 0, 7, 7], [8, 0, 11, 7], [7, 0, 11, 7]].map(|window| part(folder.path(), window, 8));
    let [first, beside, over] = paths.each_ref().map(|path| move || open(path));
    let tolerance = Tolerance::new(0.1).unwrap();
    let refused = refusal(&[first(), beside()], Some(tolerance));
    assert!(refused.contains("a tolerance has no use"), "{refused}");
    let refused = refusal(&[first(), over()], None);
    assert!(refused.contains("8 × 8 pixels, 5 × 8 pixels"), "{refused}");
    // Another display window, or none.
    for display_window in [None, Some(PixelWindow { min: [0, 0], max: [63, 31] })] {
        let mut info = beside().metadata().info;
        info.display_window = display_window;
        let pixels = PixelLists::<Rgb>::clear(4, 8);
        let path = folder.path().join("other.dsm");
        let other = super::write(&path, &pixels, info, WriteOptions::default());
        let refused = refusal(&[first(), other], None);
        assert!(refused.contains("8 × 8 pixels, 4 × 8 pixels"), "{refused}");
    }
}
