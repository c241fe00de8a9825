//! `lookup`.

use std::fmt::Write;
use std::io::Read;
use std::process::Stdio;

use dsm_core::detail::Pyramid;
use dsm_core::{
    DeepMap, Filter, FilterShape, Footprint, LevelChoice, MapInfo, Receiver, Transmittance,
    filtered_lookup,
};
use dsm_io::detail::MapWriter;
use dsm_io::{Metadata, WriteOptions};
use serde_json::Value;

use crate::maps::{Folder, SIZE, full_info, levels, mono, rgb, world, write_levels};
use crate::run;
use crate::run::program;

/// Points in and around the map, none of them on an edge of a pixel.
fn points(count: u32) -> Vec<[f64; 3]> {
    let share = |index: u32, step: f64| (f64::from(index) * step).fract();
    let [width, height] = SIZE.map(|side| f64::from(side) + 2.0);
    (1..=count)
        .map(|i| {
            [
                share(i, 0.618_034) * width - 1.0,
                share(i, 0.414_213_6) * height - 1.0,
                share(i, 0.236_068) * 16.0 - 1.0,
            ]
        })
        .collect()
}

fn csv(points: &[[f64; 3]]) -> String {
    let mut text = "x,y,z\n".to_owned();
    for [x, y, z] in points {
        writeln!(text, "{x},{y},{z}").unwrap();
    }
    text
}

fn numbers(line: &str) -> Vec<f32> {
    line.split(',').map(|number| number.parse().unwrap()).collect()
}

/// Holds every line to the lookup of its point in memory.
#[track_caller]
fn check<T: Transmittance>(
    map: &DeepMap<T>,
    answer: &str,
    points: &[[f64; 3]],
    footprint: &Footprint,
    bias: f32,
) {
    check_lines(answer, points, |point| {
        let receiver = Receiver { bias, ..point };
        filtered_lookup(map, &receiver, footprint).unwrap()
    });
}

#[track_caller]
fn check_lines<T: Transmittance>(
    answer: &str,
    points: &[[f64; 3]],
    expected: impl Fn(Receiver) -> T,
) {
    let mut lines = answer.lines();
    assert_eq!(lines.next(), Some(if T::CHANNELS == 1 { "v" } else { "r,g,b" }));
    let lines: Vec<_> = lines.collect();
    assert_eq!(lines.len(), points.len());
    for (line, point) in lines.into_iter().zip(points) {
        let [x, y, depth] = point.map(|coordinate| coordinate as f32);
        let light = expected(Receiver::new([x, y], depth));
        let light: Vec<_> = (0..T::CHANNELS).map(|channel| light.channel(channel)).collect();
        assert_eq!(numbers(line), light, "{point:?}");
    }
}

fn in_raster_space<T: Transmittance>(map: &DeepMap<T>) {
    let folder = Folder::new();
    let path = folder.map("map.dsm", map);
    let points = points(2000);
    let file = folder.write("points.csv", csv(&points));
    let filter = |shape, width| Footprint::Isotropic(Filter::new(shape, width).unwrap());
    for (switches, footprint, bias) in [
        (&[][..], Footprint::Point, 0.0),
        (&["--bias", "-0.5"], Footprint::Point, -0.5),
        (&["--filter", "point", "--bias", "2"], Footprint::Point, 2.0),
        (&["--filter", "box"], filter(FilterShape::Box, 1.0), 0.0),
        (&["--filter", "box", "--width", "2.5"], filter(FilterShape::Box, 2.5), 0.0),
        (&["--filter", "tent"], filter(FilterShape::Tent, 2.0), 0.0),
        (
            &["--filter", "gaussian", "--width", "4", "--bias", "1"],
            filter(FilterShape::Gaussian, 4.0),
            1.0,
        ),
    ] {
        let mut call = program(["lookup", "--space", "raster"]);
        call.arg(&path).arg("--points").arg(&file).args(switches);
        let answer = run::Answer::from(call.output().unwrap()).stdout();
        check(map, &answer, &points, &footprint, bias);
    }
}

fn over_levels<T: Transmittance>(map: &DeepMap<T>) {
    let (folder, levels) = (Folder::new(), levels(map));
    let path = folder.path("map.dsm");
    write_levels(&path, &levels);
    let pyramid = Pyramid::new(levels).unwrap();
    let points = points(500);
    let file = folder.write("points.csv", csv(&points));
    let filter = |shape, width| Footprint::Isotropic(Filter::new(shape, width).unwrap());
    for (switches, footprint) in [
        (&[][..], Footprint::Point),
        (&["--filter", "box", "--width", "5"], filter(FilterShape::Box, 5.0)),
        (&["--filter", "tent", "--width", "3"], filter(FilterShape::Tent, 3.0)),
    ] {
        for (level, choice) in [
            ("0", LevelChoice::Fixed(0.0)),
            ("1", LevelChoice::Fixed(1.0)),
            ("2.25", LevelChoice::Fixed(2.25)),
            ("3", LevelChoice::Fixed(3.0)),
            ("auto", LevelChoice::Auto),
        ] {
            let mut call = program(["lookup", "--space", "raster", "--level", level]);
            call.arg(&path).arg("--points").arg(&file).args(switches);
            let answer = run::Answer::from(call.output().unwrap()).stdout();
            check_lines(&answer, &points, |receiver| {
                let Ok(light) = pyramid.lookup(&receiver, &footprint, choice);
                light
            });
        }
    }
}

#[test]
fn levels_answer_as_in_memory() {
    over_levels(&mono(MapInfo::default()));
    over_levels(&rgb(MapInfo::default()));
}

#[test]
fn a_level_that_is_not_there_is_refused() {
    let folder = Folder::new();
    let (flat, path) = (folder.map("flat.dsm", &mono(MapInfo::default())), folder.path("map.dsm"));
    write_levels(&path, &levels(&mono(MapInfo::default())));
    let file = folder.write("points.csv", "x,y,z\n1,2,9\n");
    for (map, level, reason) in [
        (&flat, "1", "flat.dsm: there is no level 1: the map has one level, 0"),
        (&path, "4", "map.dsm: there is no level 4: the map has 4 levels, 0 to 3"),
        (&path, "3.5", "map.dsm: there is no level 3.5: the map has 4 levels, 0 to 3"),
    ] {
        let refused = run!("lookup", map, "--points", file, "--space", "raster", "--level", level);
        assert!(refused.refusal().ends_with(reason), "{refused:?}");
        assert_eq!(refused.stdout, "");
    }
    // The coarsest level there is serves any width.
    let wide = ["--filter", "box", "--width", "99", "--level", "auto"];
    let mut call = program(["lookup", "--space", "raster", "--points"]);
    call.arg(&file).arg(&flat).args(wide);
    let light = run::Answer::from(call.output().unwrap()).stdout();
    assert!(light.lines().nth(1).is_some_and(|light| numbers(light)[0] < 1.0), "{light}");
}

#[test]
fn mono_maps_answer_as_in_memory() {
    in_raster_space(&mono(MapInfo::default()));
}

#[test]
fn coloured_maps_answer_as_in_memory() {
    in_raster_space(&rgb(MapInfo::default()));
}

#[test]
fn points_of_the_world_go_through_the_camera() {
    let folder = Folder::new();
    let map = rgb(full_info());
    let path = folder.map("map.dsm", &map);
    // Away from the edges of pixels and depths, where rounding decides.
    let points: Vec<_> = points(2000)
        .into_iter()
        .filter(|point| point.iter().all(|part| (0.01..0.99).contains(&part.rem_euclid(1.0))))
        .collect();
    assert!(points.len() > 1800);
    let in_world: Vec<_> = points.iter().map(|&point| world(point)).collect();
    let file = folder.write("points.csv", csv(&in_world));
    let answer = run!("lookup", path, "--points", file).stdout();
    let close = |a: f32, b: f32| (a - b).abs() < 1e-5;
    for (line, point) in answer.lines().skip(1).zip(&points) {
        let [x, y, depth] = point.map(|part| part as f32);
        let light =
            filtered_lookup(&map, &Receiver::new([x, y], depth), &Footprint::Point).unwrap();
        let found = numbers(line);
        assert!((0..3).all(|channel| close(found[channel], light.channel(channel))), "{point:?}");
    }
    assert_eq!(answer, run!("lookup", path, "--points", file, "--space", "world").stdout());
}

#[test]
fn what_lies_nowhere_is_lit() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(full_info()));
    let nowhere = "x,y,z\nnan,0,3\n0,0,NaN\n1e300,0,-5\n0,0,5\n0,0,0\ninf,0,-5\n0,0,-inf\n";
    let file = folder.write("world.csv", nowhere);
    let answer = run!("lookup", path, "--points", file).warned("no point lies in the map");
    assert_eq!(answer, "v\n1\n1\n1\n1\n1\n1\n1\n");
    let outside =
        "x,y,z\n-0.1,0.5,9\n7,0.5,9\n3.5,5,9\n3.5,nan,9\n3.5,0.5,0\n3.5,0.5,-9\n3.5,0.5,inf\n";
    let file = folder.write("raster.csv", outside);
    let answer = run!("lookup", path, "--points", file, "--space", "raster");
    let answer = answer.warned("1 point has a coordinate that is no number (NaN)");
    assert_eq!(answer, "v\n1\n1\n1\n1\n1\n1\n0.100000024\n");
}

#[test]
fn columns_are_found_by_name() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(MapInfo::default()));
    let text = "id, z ,\"y\",x\r\n\"a,b\",3.5,0.5,2.5\r\n\r\nc,2.5,0.5,2.5\r\n";
    let file = folder.write("points.csv", text);
    let answer = run!("lookup", path, "--points", file, "--space", "raster").stdout();
    let mut lines = answer.lines().skip(1).map(|line| numbers(line)[0]);
    let ramp = 0.7 - 0.6 * 0.5 / 7.0;
    assert!(lines.next().is_some_and(|light| (light - ramp).abs() < 1e-6), "{answer}");
    assert_eq!(lines.collect::<Vec<_>>(), [1.0]);
}

#[test]
fn threads_change_nothing() {
    let folder = Folder::new();
    let map = mono(MapInfo::default());
    let path = folder.map("map.dsm", &map);
    // More than the program holds at a time.
    let points = points(150_000);
    let file = folder.write("points.csv", csv(&points));
    let answer = |threads| {
        run!("lookup", path, "--points", file, "--space", "raster", "--threads", threads).stdout()
    };
    let one = answer("1");
    check(&map, &one, &points, &Footprint::Point, 0.0);
    assert_eq!(one, answer("5"));
}

#[test]
fn statistics_are_one_line_of_json() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(MapInfo::default()));
    let file = folder.write("points.csv", csv(&points(10)));
    let answer = run!("lookup", path, "--points", file, "--space", "raster", "--stats");
    assert_eq!((answer.code, answer.stderr.lines().count()), (0, 1));
    let statistics: Value = serde_json::from_str(&answer.stderr).unwrap();
    let keys: Vec<_> = statistics.as_object().unwrap().keys().cloned().collect();
    assert_eq!(keys, ["lookup_s", "open_s", "points", "rays", "warnings"]);
    assert_eq!((&statistics["points"], &statistics["rays"]), (&10.into(), &0.into()));
    assert!(statistics["open_s"].as_f64().unwrap() > 0.0);
}

#[test]
fn quiet_answers_all_the_same() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(MapInfo::default()));
    let file = folder.write("points.csv", csv(&points(10)));
    let answer = run!("lookup", path, "--points", file, "--space", "raster").stdout();
    let quiet = run!("lookup", path, "--points", file, "--space", "raster", "--quiet").stdout();
    assert_eq!(answer, quiet);
}

#[test]
fn a_closed_pipe_is_success() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(MapInfo::default()));
    let file = folder.write("points.csv", csv(&points(200_000)));
    let mut call = program(["lookup", "--space", "raster", "--points"]);
    call.arg(&file).arg(&path).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = call.spawn().unwrap();
    let mut output = child.stdout.take().unwrap();
    output.read_exact(&mut [0; 2]).unwrap();
    drop(output);
    let answer = run::Answer::from(child.wait_with_output().unwrap());
    assert_eq!((answer.code, answer.stderr.as_str()), (0, ""));
}

#[test]
fn refusals_say_what_and_where() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(MapInfo::default()));
    let good = folder.write("points.csv", "x,y,z\n1,2,3\n");
    let refused = run!("lookup", path, "--points", good);
    assert!(refused.refusal().contains("map.dsm: the map has no camera"), "{refused:?}");
    for (name, text, reason) in [
        (
            "word.csv",
            "x,y,z\n1,2,3\n\n1,2,three\n",
            "word.csv: line 4: z is not a number: \"three\"",
        ),
        ("short.csv", "x,y,z\n1,2\n", "short.csv: line 2: there is no z"),
        ("column.csv", "x,y\n1,2\n", "column.csv: the header has no column z; it has x, y"),
        ("case.csv", "X,Y,Z\n", "case.csv: the header has no column x; it has X, Y, Z"),
        ("empty.csv", "", "empty.csv: there is no header: the first line names the columns, x,y,z"),
        (
            "bare.csv",
            "1,2,3\n",
            "there is no header: the first line is numbers, and has to name the columns, x,y,z",
        ),
        (
            "semicolons.csv",
            "x;y;z\n1;2;3\n",
            "the columns are separated by semicolons, and have to be by commas",
        ),
        ("break.csv", "x,y,z\n1,2,\"a\nb\"\n", "break.csv: line 2: z is not a number: \"a b\""),
    ] {
        let file = folder.write(name, text);
        let refused = run!("lookup", path, "--points", file, "--space", "raster");
        assert!(refused.refusal().ends_with(reason), "{refused:?}");
    }
    let missing = run!("lookup", path, "--points", folder.path("no.csv"), "--space", "raster");
    assert!(missing.refusal().starts_with("cannot open "), "{missing:?}");
    assert!(missing.refusal().contains("no.csv: No such file"), "{missing:?}");
    let no_map = run!("lookup", good, "--points", good, "--space", "raster");
    assert!(no_map.refusal().contains("points.csv: not a .dsm file"), "{no_map:?}");
    assert_eq!(no_map.stdout, "");
}

#[test]
fn filters_and_widths_must_fit() {
    let lookup = |switches: &[&str]| {
        let call = program(["lookup", "map.dsm", "--points", "p.csv"]).args(switches).output();
        run::Answer::from(call.unwrap())
    };
    lookup(&["--width", "2"]).is_wrong_usage("--width needs a --filter");
    lookup(&["--width", "2", "--filter", "point"]).is_wrong_usage("--width needs a --filter");
    lookup(&["--filter", "tent", "--width", "1.5"]).is_wrong_usage("at least 2 pixels");
    for width in ["0.5", "-1", "nan", "inf", "wide"] {
        lookup(&["--filter", "box", "--width", width]).is_wrong_usage("");
    }
    for level in ["-1", "nan", "inf", "fine"] {
        lookup(&["--level", level]).is_wrong_usage("must be auto or a number from 0 on");
    }
    lookup(&["--filter", "cubic"]).is_wrong_usage("cubic");
    lookup(&["--bias", "nan"]).is_wrong_usage("finite");
    lookup(&["--threads", "0"]).is_wrong_usage("threads");
    lookup(&["--space", "camera"]).is_wrong_usage("camera");
}

#[test]
fn a_filter_over_more_pixels_than_can_be_visited_is_refused() {
    let folder = Folder::new();
    let map = folder.path("huge.dsm");
    let side = (1 << 31) - 1;
    let metadata = Metadata::new(side, side, 1, MapInfo::default());
    let options = WriteOptions::default().with_tile_size(side);
    MapWriter::create(&map, metadata, options).unwrap().finish().unwrap();
    let points = folder.write("p.csv", "x,y,z\n1e9,1e9,1\n");
    for level in ["0", "auto"] {
        let answer = run!(
            "lookup", map, "--points", points, "--space", "raster", "--filter", "box", "--width",
            "1e9", "--level", level
        );
        assert!(
            answer.refusal().contains("the filter reaches 1000000002000000001 pixels"),
            "{answer:?}"
        );
    }
    let narrow = run!(
        "lookup", map, "--points", points, "--space", "raster", "--filter", "box", "--width", "64"
    );
    assert_eq!(narrow.warned("the map holds nothing"), "v\n1\n");
}
