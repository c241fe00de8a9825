//! `verify`.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use dsm_core::{DeepMap, PixelListsBuilder, Rgb, Transmittance, Vertex};
use dsm_io::{AchievedError, Limits, MapReader, WriteOptions, write_map};
use serde_json::{Value, json};

use crate::maps::{Folder, full_info, mono, rgb};
use crate::run;
use crate::run::{Answer, program};

#[test]
fn whole_maps_pass() {
    let folder = Folder::new();
    let mono = folder.map("mono.dsm", &mono(full_info()));
    let rgb = folder.map("rgb.dsm", &rgb(full_info()));
    let told = run!("verify", mono, rgb, "--json").json();
    let stated = json!([
        {"max_error": 0.01, "mean_error": 0.0, "depth_error": 0.0, "error_at_depth": 0.01}
    ]);
    let file = |path: &Path| json!({"path": path, "ok": true, "errors": [], "stated": stated, "notes": []});
    let files = [file(&mono), file(&rgb)];
    assert_eq!(told, json!({"ok": true, "files": files, "warnings": []}));
    let text = run!("verify", mono).stdout();
    assert_eq!(text, format!("{}: ok\n", mono.display()));
}

#[test]
fn a_changed_byte_is_found() {
    let folder = Folder::new();
    let whole = folder.map("whole.dsm", &mono(full_info()));
    let bytes = std::fs::read(&whole).unwrap();
    for position in (0..bytes.len()).step_by(61) {
        let mut changed = bytes.clone();
        changed[position] ^= 0x10;
        let damaged = folder.write("damaged.dsm", &changed);
        let answer = run!("verify", whole, damaged, "--json");
        assert!(answer.refusal().starts_with("1 of 2 files failed: "), "{position}: {answer:?}");
        let told: Value = serde_json::from_str(&answer.stdout).unwrap();
        assert_eq!(told["ok"], json!(false));
        assert_eq!(
            (&told["files"][0]["ok"], &told["files"][1]["ok"]),
            (&json!(true), &json!(false))
        );
        assert!(told["files"][1]["errors"][0].as_str().unwrap().contains("damaged.dsm"));
    }
}

#[test]
fn files_that_are_no_maps_fail() {
    let folder = Folder::new();
    let text = folder.write("text.dsm", "not a map");
    let answer = run!("verify", text, folder.path("missing.dsm"));
    assert!(answer.refusal().starts_with("2 of 2 files failed: "), "{answer:?}");
    assert!(answer.stdout.contains("text.dsm: 1 error\n"), "{answer:?}");
    assert_eq!(answer.stdout.matches("missing.dsm: cannot open: No such file").count(), 1);
    assert_eq!(answer.stdout.matches("No such file").count(), 1, "{answer:?}");
}

#[test]
fn a_failed_check_stays_one_when_nobody_listens() {
    let folder = Folder::new();
    let damaged = folder.write("damaged.dsm", "not a map");
    let mut call = program(["verify".as_ref(), damaged.as_os_str()]);
    let mut child = call.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let answer = Answer::from(child.wait_with_output().unwrap());
    assert!(answer.refusal().starts_with("1 of 1 files failed: "), "{answer:?}");
}

/// A map like the one in `path`, with other vertices.
fn changed<T: Transmittance>(
    path: &Path,
    folder: &Folder,
    change: impl Fn(Vertex<T>) -> Vertex<T>,
) -> PathBuf {
    let reader = MapReader::open(path, &Limits::default()).unwrap();
    let map = reader.read_map::<T>(0).unwrap();
    let pixels = map.pixels().view();
    let mut others = PixelListsBuilder::new(pixels.width(), pixels.height());
    for function in pixels.functions() {
        function.vertices().for_each(|vertex| others.push(change(vertex)));
        others.finish_pixel().unwrap();
    }
    let metadata = reader.metadata().clone();
    let map = DeepMap::new(metadata.info, others.finish().unwrap());
    let output = folder.path("changed.dsm");
    let options = WriteOptions::default();
    write_map(&output, metadata, &map, AchievedError::NONE, options).unwrap();
    output
}

fn quantized_maps_keep_their_bound<T: Transmittance>(scene: &str) {
    let folder = Folder::new();
    let [exact, quantized] = ["exact.dsm", "quantized.dsm"].map(|name| folder.path(name));
    let few = ["--resolution", "64", "--samples", "4", "--quiet"];
    let bake = |map: &Path, more: &[&str]| {
        let base = ["bake", scene, "-o", map.to_str().unwrap()];
        run::run(base.iter().chain(&few).chain(more)).stdout();
    };
    bake(&exact, &["--tolerance", "0"]);
    bake(&quantized, &["--tolerance", "0.01", "--codec", "quantized"]);
    let image = folder.path("exact.exr");
    run!("convert", exact, image, "--quiet").stdout();
    for source in [&exact, &image] {
        run!("verify", quantized, "--against", source).stdout();
    }
    // Without their depth error they are as far off as a step is high.
    let told = run!("diff", quantized, exact, "--json").json();
    assert!(told["max"].as_f64().unwrap() > 0.2, "{told}");
    // A source from which it would have moved depths too far, one from which it
    // would have moved them towards the light, and one of other values.
    let moved = |share: f32| {
        changed::<T>(&exact, &folder, |vertex| Vertex::new(vertex.z * (1.0 + share), vertex.value))
    };
    let scaled = |share: f32| {
        changed::<T>(&exact, &folder, |Vertex { z, value }| {
            let value = |channel| 1.0 + (value.channel(channel) - 1.0) * share;
            Vertex::new(z, T::from_channels(value))
        })
    };
    let refused = |source: &Path| {
        let answer = run!("verify", quantized, "--against", source);
        assert!(answer.refusal().contains("against"), "{answer:?}");
    };
    refused(&moved(-1e-3));
    refused(&moved(1e-3));
    refused(&scaled(0.95));
}

#[test]
fn depths_that_were_moved_as_far_as_a_map_states_are_within_its_bound() {
    quantized_maps_keep_their_bound::<f32>("builtin:foliage");
    quantized_maps_keep_their_bound::<Rgb>("builtin:stained-glass");
}
