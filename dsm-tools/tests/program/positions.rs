//! `lookup --positions`.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use exr::prelude::*;

use crate::maps::Folder;
use crate::run;

const SIZE: [usize; 2] = [61, 47];

/// Positions around the hairball, some of them nowhere.
fn position([x, y]: [usize; 2]) -> [f32; 3] {
    if (x + y) % 29 == 0 {
        return [f32::NAN; 3];
    }
    [x as f32 / 30.0 - 1.0, (x * y) as f32 / 3000.0 - 0.5, y as f32 / 23.0 - 1.0]
}

fn positions() -> Vec<[f32; 3]> {
    let [width, height] = SIZE;
    (0..height).flat_map(|y| (0..width).map(move |x| position([x, y]))).collect()
}

fn write_positions(path: &Path, names: [&str; 3], encoding: Encoding, halves: bool) {
    let channels = names.iter().enumerate().map(|(axis, &name)| {
        let values = positions().into_iter().map(|position| position[axis]);
        let values = if halves {
            FlatSamples::F16(values.map(f16::from_f32).collect())
        } else {
            FlatSamples::F32(values.collect())
        };
        AnyChannel::new(name, values)
    });
    let layer = Layer::new(
        (SIZE[0], SIZE[1]),
        LayerAttributes::named("beauty").with_position(Vec2(5, -3)),
        encoding,
        AnyChannels::sort(channels.collect()),
    );
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((0, 0), (80, 50));
    image.write().to_file(path).unwrap();
}

fn read(path: &Path) -> (Vec<Vec<f32>>, Vec2<i32>, IntegerBounds) {
    let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let image = image.first_valid_layer().all_attributes().from_file(path).unwrap();
    let list = &image.layer_data.channel_data.list;
    // R, G, B, against their order in the file.
    let columns = list.iter().rev().map(|channel| channel.sample_data.values_as_f32().collect());
    let position = image.layer_data.attributes.layer_position;
    (columns.collect(), position, image.attributes.display_window)
}

#[test]
fn pictures_are_answered_as_lists_are() {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name);
    let tiles = Encoding {
        compression: Compression::RLE,
        blocks: Blocks::Tiles(Vec2(16, 24)),
        line_order: LineOrder::Increasing,
    };
    let lines = Encoding { blocks: Blocks::ScanLines, compression: Compression::ZIP16, ..tiles };
    let upwards = Encoding { line_order: LineOrder::Decreasing, ..lines };
    for (scene, kind, method) in [
        ("hairball", "deep", &["--filter", "tent", "--width", "3"][..]),
        ("stained-glass", "deep", &[]),
        ("hairball", "fragments", &["--rays", "16"]),
        ("hairball", "layers", &["--method", "coherence", "--rays", "64"]),
    ] {
        let (map, points) = (path("map.dsm"), path("points.csv"));
        let scene = format!("builtin:{scene}");
        run!("bake", scene, "-o", map, "--kind", kind, "--resolution", "64", "--quiet").stdout();
        let (picture, out) = (path("P.exr"), path("shadow.exr"));
        for (names, encoding, halves) in [
            (["P.x", "P.y", "P.z"], lines, false),
            (["P.R", "P.G", "P.B"], tiles, true),
            (["R", "G", "B"], upwards, false),
        ] {
            write_positions(&picture, names, encoding, halves);
            let mut list = "x,y,z\n".to_owned();
            for position in positions() {
                let [x, y, z] =
                    position.map(|at| if halves { f16::from_f32(at).to_f32() } else { at });
                let [x, y, z] = [x, y, z].map(f64::from);
                writeln!(list, "{x},{y},{z}").unwrap();
            }
            fs::write(&points, list).unwrap();
            let ask = |more: &[&std::ffi::OsStr]| {
                let mut all = vec![std::ffi::OsStr::new("lookup"), map.as_os_str()];
                all.extend(method.iter().map(std::ffi::OsStr::new));
                all.extend(more);
                crate::run::run(all)
            };
            // Lights are wide for a filter, which is said.
            let list = ask(&["--points".as_ref(), points.as_os_str()]);
            assert_eq!(list.code, 0, "{list:?}");
            let answers = list.stdout;
            let expected: Vec<Vec<f32>> = answers
                .lines()
                .skip(1)
                .map(|line| line.split(',').map(|value| value.parse().unwrap()).collect())
                .collect();
            let asked =
                ask(&["--positions".as_ref(), picture.as_os_str(), "-o".as_ref(), out.as_os_str()]);
            assert_eq!((asked.code, asked.stdout.as_str()), (0, ""), "{asked:?}");
            let (columns, position, window) = read(&out);
            assert_eq!((position, window.size), (Vec2(5, -3), Vec2(80, 50)));
            assert_eq!(columns.len(), expected[0].len());
            let mut dark = 0;
            for (pixel, expected) in expected.iter().enumerate() {
                let found: Vec<f32> = columns.iter().map(|column| column[pixel]).collect();
                assert_eq!(&found, expected, "{scene} {kind} pixel {pixel}");
                dark += usize::from(expected[0] < 1.0);
            }
            assert!(dark > 20, "{dark}");
        }
    }
}

#[test]
fn pictures_without_positions_are_refused() {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name);
    let (map, picture, out) = (path("map.dsm"), path("P.exr"), path("shadow.exr"));
    run!("bake", "builtin:hairball", "-o", map, "--resolution", "16", "--quiet").stdout();
    write_positions(&picture, ["N.x", "N.y", "N.z"], Encoding::default(), false);
    let refused = run!("lookup", map, "--positions", picture, "-o", out);
    assert!(refused.refusal().contains("but N.x, N.y, N.z"), "{refused:?}");
    write_positions(&picture, ["P.x", "P.y", "P.z"], Encoding::default(), false);
    let bytes = fs::read(&picture).unwrap();
    for length in [0, 100, bytes.len() / 2, bytes.len() - 1] {
        fs::write(&picture, &bytes[..length]).unwrap();
        run!("lookup", map, "--positions", picture, "-o", out).refusal();
        assert!(!out.exists(), "{length}");
    }
    run!("lookup", map, "--positions", picture).is_wrong_usage("--output");
    run!("lookup", map).is_wrong_usage("--points");
}
