//! Files of the format that are legal and ask for much, or break its rules.

use std::path::{Path, PathBuf};

use crate::maps::Folder;
use crate::run;

/// A file from beside the project, or `None` and a message.
fn given(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/cases/dsm").join(name);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

#[test]
fn a_name_longer_than_a_line_is_cut() {
    let Some(map) = given("attr_long_panics.dsm") else { return };
    let told = run!("inspect", map).stdout();
    assert!(told.lines().all(|line| line.chars().count() < 300), "{told}");
    assert!(run!("inspect", map, "--json").stdout().len() > 65_536);
    run!("verify", map).stdout();
    // What a conversion loses is named, too.
    let folder = Folder::new();
    let told = run!("convert", map, folder.path("named.exr")).stdout();
    assert!(told.contains("lost: attributes nnn") && told.len() < 3000, "{told}");
}

#[test]
fn seventy_thousand_steps_go_to_an_image_and_back() {
    let Some(map) = given("many-steps.dsm") else { return };
    let folder = Folder::new();
    let (image, back) = (folder.path("steps.exr"), folder.path("back.dsm"));
    let told = run!("convert", map, image).stdout();
    assert!(told.contains("70000 samples, at most 70000 a pixel"), "{told}");
    run!("convert", image, back).stdout();
    run!("verify", back, "--against", image).stdout();
    let difference = run!("diff", map, back, "--json").json();
    assert!(difference["max"].as_f64().is_some_and(|max| max < 1e-5), "{difference}");
}

#[test]
fn tiles_as_large_as_readers_take_are_read() {
    let Some(map) = given("unpacks-to-256MiB.dsm") else { return };
    run!("inspect", map).stdout();
    run!("inspect", map, "--pixel", "7999,7999", "--json").json();
    run!("verify", map).stdout();
}

#[test]
fn sums_that_wrap_around_are_no_panic() {
    let Some(map) = given("vertex-counts-wrap.dsm") else { return };
    let told = run!("inspect", map, "--json").json();
    // Of the 2⁶³ of two tiles the sum is as large as numbers are.
    assert!(told["levels"][0]["vertices"].as_u64().is_some_and(|count| count > 1 << 62), "{told}");
    run!("inspect", map).stdout();
    assert!(run!("verify", map).refusal().contains("no room"));
    let folder = Folder::new();
    let output = folder.path("output.dsm");
    for arguments in [["convert"], ["mip"]] {
        let refused = match arguments {
            ["mip"] => run!("mip", map, "-o", output),
            _ => run!("convert", map, output),
        };
        assert!(refused.refusal().contains("no room"), "{refused:?}");
    }
}

#[test]
fn maps_of_a_kind_that_has_another_name_are_refused_in_a_line() {
    for name in ["frag_wider_range.dsm", "empty-layers-16384.dsm"] {
        let Some(map) = given(name) else { return };
        let refusal = run!("inspect", map);
        assert!(refusal.refusal().contains("no key \"coverage\""), "{refusal:?}");
    }
}

#[test]
fn layers_with_a_tolerance_break_their_kind() {
    let Some(map) = given("layers-tolerance-resets.dsm") else { return };
    for answer in [run!("verify", map), run!("inspect", map)] {
        assert!(answer.refusal().contains("a tolerance of 0 and no resets"), "{answer:?}");
    }
}
