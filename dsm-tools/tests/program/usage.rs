//! What no command does.

use crate::maps::{Folder, full_info, mono};
use crate::run;

const COMMANDS: [&str; 15] = [
    "bake",
    "completions",
    "convert",
    "demo",
    "diff",
    "inspect",
    "lookup",
    "man",
    "merge",
    "mip",
    "plan",
    "render",
    "report",
    "step",
    "verify",
];

#[test]
fn help_and_version_are_no_errors() {
    assert!(run!("--help").stdout().contains("lookup"));
    assert!(run!("lookup", "--help").stdout().contains("--points"));
    assert!(run!("--version").stdout().starts_with("dsm-tools "));
}

/// The width of a terminal is known to the program as COLUMNS where there is none.
#[test]
fn help_is_as_wide_as_the_terminal() {
    for command in COMMANDS {
        let help = |columns: &str| {
            let mut call = run::program([command, "--help"]);
            run::Answer::from(call.env("COLUMNS", columns).output().unwrap()).stdout()
        };
        let widest = |help: &str| help.lines().map(|line| line.chars().count()).max();
        let (narrow, wide) = (help("80"), help("100"));
        assert!(widest(&narrow) <= Some(80), "{narrow}");
        assert!(widest(&wide) <= Some(100), "{wide}");
        assert_ne!(narrow, wide, "{command}");
        assert!(narrow.contains(&format!("\nExamples:\n  dsm-tools {command} ")), "{narrow}");
    }
}

#[test]
fn wrong_usage_has_exit_code_2() {
    let none: [&str; 0] = [];
    assert_eq!(run::run(none).code, 2);
    run!("paint").is_wrong_usage("paint");
    run!("lookup", "map.dsm").is_wrong_usage("--points");
    run!("verify").is_wrong_usage("FILE");
    run!("inspect", "a.dsm", "b.dsm").is_wrong_usage("b.dsm");
}

/// A switch comes with what it switches: taken and ignored, it would lie.
#[test]
fn what_is_not_there_is_not_accepted() {
    run!("render", "a", "-o", "b.png", "--crop", "0").is_wrong_usage("--crop");
    run!("lookup", "a", "--points", "b", "--sub-lights", "2").is_wrong_usage("--sub-lights");
    for method in ["views", "radiosity"] {
        run!("lookup", "a", "--points", "b", "--method", method).is_wrong_usage(method);
    }
}

/// A scene that is not there, and would be opened first: the name of the output
/// comes before all work.
#[test]
fn outputs_are_checked_before_the_work() {
    let folder = Folder::new();
    let map = folder.map("map.dsm", &mono(full_info()));
    let map = map.to_str().unwrap();
    let file = folder.write("file", "");
    for place in [folder.path("missing"), file.clone()] {
        let out = |name: &str| place.join(name).into_os_string().into_string().unwrap();
        for call in [
            &["bake", "missing.toml", "-o", &out("a.dsm")][..],
            &["convert", "missing.exr", &out("a.dsm")],
            &["convert", "missing.dsm", &out("a.exr")],
            &["mip", "missing.dsm", "-o", &out("a.dsm")],
            &["merge", "missing.dsm", "missing.dsm", "-o", &out("a.dsm")],
            &["render", "missing.toml", "-o", &out("a.png")],
            &["inspect", "missing.dsm", "--pixel", "0,0", "--plot", &out("a.svg")],
            &["inspect", "missing.dsm", "--slice", "1", "--image", &out("a.exr")],
        ] {
            let answer = run::run(call);
            let refusal = answer.refusal();
            assert!(refusal.contains("cannot create a file beside it"), "{call:?}: {refusal}");
        }
    }
    // A folder in the way, and one that would have to be a file's.
    let taken = folder.path("taken.dsm");
    std::fs::create_dir(&taken).unwrap();
    let answer = run!("mip", map, "-o", taken);
    assert!(answer.refusal().contains("not a regular file"), "{answer:?}");
    let demo = folder.path("demo");
    std::fs::create_dir_all(demo.join("render.png")).unwrap();
    let answer = run!("demo", "--out", demo);
    assert!(answer.refusal().contains("render.png"), "{answer:?}");
    assert_eq!(answer.stdout, "");
    run!("demo", "--out", file.join("demo")).refusal();
    // Nothing is left of the checks.
    assert_eq!(std::fs::read_dir(folder.path("")).unwrap().count(), 4);
}
