//! What newcomers do, and the one line that each is told: a golden file.

use std::fmt::Write as _;
use std::path::Path;

use crate::maps::Folder;
use crate::run;

/// The lines that are expected; `UPDATE_GOLDEN=1` writes them anew.
const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/program/mistakes.golden");

/// Files that mistakes are made with: names that stand for themselves in the answers.
fn prepare(folder: &Folder) {
    let here = |name: &str| folder.path(name);
    let bake = |name: &str, words: &[&str]| {
        let mut call = vec!["bake".to_owned(), "builtin:spinning-sphere".to_owned()];
        call.extend(words.iter().map(|word| (*word).to_owned()));
        call.extend(["-o".to_owned(), here(name).display().to_string(), "--quiet".to_owned()]);
        let answer = run::run(&call);
        assert_eq!(answer.code, 0, "{answer:?}");
    };
    bake("deep.dsm", &["--resolution", "16"]);
    bake("small.dsm", &["--resolution", "8"]);
    bake("views.dsm", &["--resolution", "16", "--kind", "views"]);
    bake("fragments.dsm", &["--resolution", "16", "--kind", "fragments"]);
    let whole = std::fs::read(here("deep.dsm")).unwrap();
    std::fs::write(here("cut.dsm"), &whole[..whole.len() / 2]).unwrap();
    folder.write("points.csv", "x,y,z\n0,0,0\n");
    folder.write("no-header.csv", "1,2,3\n4,5,6\n");
    folder.write("words.csv", "x,y,z\n0,0,0\n1,two,3\n");
    folder.write("nan.csv", "x,y,z\n0,0,0\nnan,0,0\n");
    folder.write("picture.png", "\u{89}PNG no map");
    folder.write("no-light.toml", "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n");
    folder.write("typo.toml", "[light]\neye = [0, 5, 0]\ntarget = [0, 0, 0]\nfow = 40.0\n");
    folder.write(
        "no-model.toml",
        "[light]\neye = [0, 5, 0]\ntarget = [0, 0, 0]\n\n[[object]]\nmesh = \"missing.obj\"\n",
    );
    std::fs::create_dir(here("folder")).unwrap();
}

/// Calls with a mistake each, as words.
const MISTAKES: &[&str] = &[
    "bek builtin:hairball -o map.dsm",
    "bake builtin:hairball",
    "bake builtin:hairbal -o map.dsm",
    "bake builtin:hairball -o map.dsm --resoluton 64",
    "bake builtin:hairball -o map.dsm --resolution 0",
    "bake builtin:hairball -o map.dsm --kind fragmnets",
    "bake builtin:hairball -o map.dsm --tolerance 1.5",
    "bake builtin:hairball -o map.exr",
    "bake builtin:hairball -o nowhere/map.dsm",
    "bake missing.toml -o map.dsm",
    "bake folder -o map.dsm",
    "bake no-light.toml -o map.dsm",
    "bake typo.toml -o map.dsm",
    "bake no-model.toml -o map.dsm",
    "bake picture.png -o map.dsm",
    "inspect missing.dsm",
    "inspect folder",
    "inspect picture.png",
    "inspect cut.dsm",
    "inspect deep.dsm --pixel 99,99",
    "inspect deep.dsm --pixel 3",
    "inspect views.dsm --slice 1 --image slice.png",
    "inspect deep.dsm --html page.txt",
    "lookup deep.dsm",
    "lookup deep.dsm --points missing.csv",
    "lookup deep.dsm --points no-header.csv",
    "lookup deep.dsm --points words.csv",
    "lookup deep.dsm --points nan.csv",
    "lookup deep.dsm --points points.csv --method trace",
    "lookup views.dsm --points points.csv --method filter",
    "lookup fragments.dsm --points points.csv --method prefilter",
    "render builtin:spinning-sphere -o picture.jpg",
    "render builtin:spinning-sphere -o out.png --map deep.dsm --method trace",
    "render builtin:spinning-sphere -o out.png --map missing.dsm",
    "render builtin:spinning-sphere -o out.png --method raytrace",
    "merge deep.dsm small.dsm -o map.dsm",
    "diff deep.dsm small.dsm",
    "diff deep.dsm fragments.dsm",
    "mip fragments.dsm -o map.dsm",
    "convert deep.dsm map.png",
    "convert picture.png map.dsm",
    "verify deep.dsm --against small.dsm",
    "report deep.dsm",
];

#[test]
fn every_mistake_has_one_line_that_says_what_to_do() {
    let folder = Folder::new();
    prepare(&folder);
    let mut told = String::new();
    for mistake in MISTAKES {
        let mut program = run::program(mistake.split(' '));
        let answer = run::Answer::from(program.current_dir(folder.path("")).output().unwrap());
        let lines: Vec<&str> = answer.stderr.lines().collect();
        assert_eq!(lines.len(), 1, "{mistake}: {answer:?}");
        assert!(lines[0].starts_with("error: ") || lines[0].starts_with("warning: "), "{lines:?}");
        writeln!(told, "$ dsm-tools {mistake}\n[{}] {}\n", answer.code, lines[0]).unwrap();
    }
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(GOLDEN, &told).unwrap();
    }
    let expected = std::fs::read_to_string(Path::new(GOLDEN)).unwrap_or_default();
    assert_eq!(told, expected, "see {GOLDEN}");
}

/// Colours are for terminals, and for nobody who set NO_COLOR.
#[test]
fn colours_are_for_who_wants_them() {
    let help = |variables: &[(&str, &str)]| {
        let mut program = run::program(["bake", "--help"]);
        program.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
        run::Answer::from(program.envs(variables.iter().copied()).output().unwrap()).stdout()
    };
    assert!(!help(&[]).contains('\u{1b}'));
    assert!(help(&[("CLICOLOR_FORCE", "1")]).contains('\u{1b}'));
    assert!(!help(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]).contains('\u{1b}'));
}
