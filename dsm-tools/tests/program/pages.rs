//! Pages, reports, completions and manual pages; files that come in by pipes.

use std::fs::{File, read, read_dir, read_to_string};
use std::path::{Path, PathBuf};

use dsm_core::Rgb;

use crate::maps::{Folder, full_info, map, mono};
use crate::run;
use crate::run::Answer;

fn sample() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/sample/tuft.exr")
}

/// Whatever a page names must be in it.
fn asks_for_nothing(page: &str) {
    let svg = "http://www.w3.org/2000/svg";
    let rest = page.replace(svg, "");
    for address in ["http:", "https:", "//cdn", "src=\"/", "import(", "fetch(", "XMLHttpRequest"] {
        assert!(!rest.contains(address), "{address}");
    }
}

#[test]
fn pages_are_the_same_bytes_and_hold_all_levels() {
    let folder = Folder::new();
    let coloured = map(full_info(), |blocked| Rgb::new(1.0 - blocked, 1.0 - 0.5 * blocked, 1.0));
    let plain = folder.map("plain.dsm", &coloured);
    let levels = folder.path("levels.dsm");
    run!("mip", plain, "-o", levels, "--quiet").stdout();
    let pages = ["a.html", "b.html"].map(|name| {
        let page = folder.path(name);
        run!("inspect", levels, "--html", page, "--json").json();
        read_to_string(page).unwrap()
    });
    assert_eq!(pages[0], pages[1]);
    asks_for_nothing(&pages[0]);
    assert_eq!(pages[0].matches("type=\"application/octet-stream\"").count(), 4);
    // On stdout the page is all.
    assert_eq!(run!("inspect", levels, "--html", "-").stdout(), pages[0]);
}

#[test]
fn two_maps_stand_on_one_page() {
    let folder = Folder::new();
    let made = folder.path("tuft.dsm");
    run!("convert", sample(), made, "--tolerance", "0.05", "--quiet").stdout();
    let page = folder.path("both.html");
    let told = run!("diff", made, sample(), "--html", page, "--json", "--quiet").json();
    let page = read_to_string(page).unwrap();
    asks_for_nothing(&page);
    for text in ["map-0-level-0", "map-1-level-0", "tuft.dsm and tuft.exr"] {
        assert!(page.contains(text), "{text}");
    }
    assert!(page.contains(&format!("\"max\":{}", told["max"])));
}

/// No text of a file becomes a part of the page.
#[test]
fn names_and_attributes_are_text() {
    let folder = Folder::new();
    let path = folder.map("a<script>b.dsm", &mono(full_info()));
    let page = run!("inspect", path, "--html", "-").stdout();
    assert!(page.contains("a&lt;script&gt;b.dsm") && page.contains("a\\u003cscript>b.dsm"));
    assert!(!page.contains("a<script>"));
}

#[test]
fn files_come_in_by_pipes() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(full_info()));
    let piped = |words: &[&str], file: &Path| {
        let mut program = run::program(words);
        Answer::from(program.stdin(File::open(file).unwrap()).output().unwrap())
    };
    let told = piped(&["inspect", "-", "--json"], &path).json();
    assert_eq!(told, run!("inspect", path, "--json").json());
    let points = folder.write("points.csv", "x,y,z\n1.5,0.5,2\n2.5,4.5,20\n");
    let words = ["lookup", path.to_str().unwrap(), "--space", "raster", "--points"];
    let piped_answer = piped(&[&words[..], &["-"]].concat(), &points).stdout();
    assert_eq!(piped_answer, run::run([&words[..], &[points.to_str().unwrap()]].concat()).stdout());
    assert_eq!(piped_answer.lines().count(), 3);
    let [made, expected] = ["made.dsm", "expected.dsm"].map(|name| folder.path(name));
    piped(&["convert", "-", made.to_str().unwrap(), "--quiet"], &sample()).stdout();
    run!("convert", sample(), expected, "--quiet").stdout();
    assert_eq!(read(made).unwrap(), read(expected).unwrap());
}

#[test]
fn images_are_told_part_by_part() {
    let told = run!("inspect", sample(), "--json", "--pixel", "14,11").json();
    assert_eq!(told["format"], "openexr");
    let part = &told["parts"][0];
    assert_eq!([&part["width"], &part["height"]], [48, 48]);
    assert_eq!(part["type"], "deep scan lines");
    let names: Vec<_> = part["channels"].as_array().unwrap().iter().map(|it| &it["name"]).collect();
    assert_eq!(names, ["A", "Z", "ZBack"]);
    // What `convert` counts.
    let folder = Folder::new();
    let made = run!("convert", sample(), folder.path("map.dsm"), "--json", "--quiet").json();
    assert_eq!(part["samples"]["total"], made["samples"]);
    assert_eq!(told["pixel"]["samples"].as_array().unwrap().len(), 3);
    assert_eq!(part["world_to_camera"].as_array().unwrap().len(), 16);
    let refusal = run!("inspect", sample(), "--pixel", "48,0");
    assert!(refusal.refusal().contains("outside"), "{refusal:?}");
    // A flat image without depth is told all the same.
    let picture = folder.path("picture.exr");
    let words = ["--resolution", "8", "--samples", "1", "--factor", "--method", "reference"];
    let scene = ["render", "builtin:spinning-sphere", "-o", picture.to_str().unwrap(), "--quiet"];
    run::run([&scene[..], &words].concat()).stdout();
    let told = run!("inspect", picture, "--json").json();
    assert_eq!(told["parts"][0]["type"], "flat scan lines");
    assert!(told["parts"][0]["samples"].is_null() && told["parts"][0]["no_samples"].is_string());
}

#[test]
fn shells_and_readers_know_every_command() {
    let folder = Folder::new();
    let pages = folder.path("man");
    run!("man", pages).stdout();
    let help = run!("--help").stdout();
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| line.starts_with("  "))
        .filter(|line| !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    assert_eq!(commands.len(), 15, "{commands:?}");
    assert_eq!(read_dir(&pages).unwrap().count(), commands.len() + 1);
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = run!("completions", shell).stdout();
        for command in &commands {
            assert!(script.contains(command), "{shell} {command}");
        }
    }
    for command in commands {
        let page = read_to_string(pages.join(format!("dsm-tools-{command}.1"))).unwrap();
        assert!(page.contains(&format!("dsm\\-tools\\-{command}")), "{page}");
        assert!(!page.contains("commit"), "{command}");
    }
    assert!(read_to_string(pages.join("dsm-tools-bake.1")).unwrap().contains("resolution"));
}

#[test]
fn reports_are_the_same_bytes() {
    let folder = Folder::new();
    let maps = ["fragments", "prefiltered", "attenuation"].map(|kind| {
        let map = folder.path(&format!("{kind}.dsm")).display().to_string();
        let bake = ["bake", "builtin:spinning-sphere", "--resolution", "16", "--kind", kind];
        // What moves is as it is at mid-shutter, which it says.
        assert_eq!(run::run([&bake[..], &["-o", &map, "--quiet"]].concat()).code, 0);
        map
    });
    let report = |name: &str, more: &[&str]| {
        let page = folder.path(name);
        let words = ["--resolution", "16x12", "--samples", "1", "--rays", "4", "--quiet", "--html"];
        let mut call = vec!["report", "builtin:spinning-sphere"];
        call.extend(maps.iter().map(String::as_str));
        call.extend(words);
        call.push(page.to_str().unwrap());
        call.extend(more);
        run::run(call).stdout();
        read_to_string(page).unwrap()
    };
    let page = report("a.html", &["--threads", "1"]);
    assert_eq!(page, report("b.html", &["--threads", "3"]));
    asks_for_nothing(&page);
    for text in ["filter", "trace", "prefilter", "hybrid", "attenuation", "pcf", "coherence"] {
        assert!(page.contains(&format!("<th scope=\"row\">{text}</th>")), "{text}");
    }
    // Of a map that is given, and of those that are baked.
    assert!(page.contains("<td>fragments.dsm</td>") && page.contains("<td>baked, deep</td>"));
    assert!(!page.contains("render s"));
    assert!(report("c.html", &["--times"]).contains("render s"));
}
