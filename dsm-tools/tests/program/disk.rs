//! Disks that are full, and programs that are killed while they write.
#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use dsm_core::{DeepMap, MapInfo, PixelListsBuilder, Vertex};
use dsm_io::{AchievedError, Metadata, Packing, WriteOptions, write_map};

use crate::maps::{Folder, full_info, mono};
use crate::run;
use crate::run::{Answer, program};

fn image() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/sample/tuft.exr")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Runs a script, whose `$1` and so on are these.
fn shell(script: &str, arguments: &[&Path]) -> Output {
    Command::new("sh").args(["-c", script, "sh"]).args(arguments).output().unwrap()
}

#[test]
fn a_limit_on_the_size_of_files_is_an_error() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    run!("convert", image(), map).stdout();
    let tools = Path::new(env!("CARGO_BIN_EXE_dsm-tools"));
    let out = [folder.write("out.dsm", "old"), folder.write("out.exr", "old")];
    for (command, arguments) in [
        (r#"exec "$1" convert "$2" "$3""#, [image(), out[0].clone()]),
        (r#"exec "$1" convert "$2" "$3""#, [map.clone(), out[1].clone()]),
        (r#"exec "$1" merge "$2" "$2" -o "$3""#, [map.clone(), out[0].clone()]),
    ] {
        // Blocks of 512 bytes or, in some shells, 1024.
        let script = format!("ulimit -f 4; {command}");
        let answer = Answer::from(shell(&script, &[tools, &arguments[0], &arguments[1]]));
        let refusal = answer.refusal();
        assert!(refusal.contains("cannot write: File too large"), "{refusal}");
        assert_eq!(fs::read(&arguments[1]).unwrap(), b"old");
    }
    assert_eq!(names(&folder.path("")), ["map.dsm", "out.dsm", "out.exr"]);
}

/// Mounts a small file system, where that is allowed.
#[test]
fn a_full_disk_leaves_the_old_file() {
    let folder = Folder::new();
    let mount = folder.path("mount");
    fs::create_dir(&mount).unwrap();
    let old = folder.map("old.dsm", &mono(full_info()));
    let tools = Path::new(env!("CARGO_BIN_EXE_dsm-tools"));
    let script = r#"
        exec unshare --mount --map-root-user sh -c '
            mount -t tmpfs -o size=16k tmpfs "$1" || exit 77
            cp "$2" "$1/map.dsm" || exit 78
            "$3" convert "$4" "$1/map.dsm" --block none --quiet
            code=$?
            cmp "$2" "$1/map.dsm" || exit 79
            [ "$(ls -A "$1")" = map.dsm ] || exit 80
            exit $code' sh "$@""#;
    let output = shell(script, &[&mount, &old, tools, &image()]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(77) || stderr.contains("unshare: ") {
        eprintln!("SKIPPED: no file system may be mounted here: {stderr}");
        return;
    }
    let answer = Answer::from(output);
    let refusal = answer.refusal();
    assert!(refusal.contains("map.dsm: cannot write: No space left on device"), "{refusal}");
}

/// 192 × 192 pixels of 24 steps each, at depths that don't pack well.
fn large_map(path: &Path) {
    let size = 192;
    let mut random = 1_u32;
    let mut pixels = PixelListsBuilder::new(size, size);
    for _ in 0..size * size {
        let (mut z, mut left) = (1.0_f32, 1.0_f32);
        for _ in 0..24 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            z += (1 + (random >> 8)) as f32 / (1 << 24) as f32;
            pixels.push(Vertex::new(z, left));
            left *= 0.9;
            pixels.push(Vertex::new(z, left));
        }
        pixels.finish_pixel().unwrap();
    }
    let map = DeepMap::new(MapInfo::default(), pixels.finish().unwrap());
    let metadata = Metadata::new(size, size, 1, *map.info());
    let options = WriteOptions::default().with_packing(Packing::Plain);
    write_map(path, metadata, &map, AchievedError::NONE, options).unwrap();
}

/// Kills the program 200 times while it converts, from its start to past its
/// end: the old file is there or the new one, and what is left beside it goes
/// with the next write.
#[test]
#[ignore = "takes a minute; see docs/CONTRIBUTING.md"]
fn a_killed_program_leaves_the_old_file_or_the_new() {
    const KILLS: u32 = 200;
    let folder = Folder::new();
    let source = folder.path("source.dsm");
    large_map(&source);
    fs::create_dir(folder.path("out")).unwrap();
    let target = folder.path("out/map.dsm");
    let convert = || program(["convert".as_ref(), source.as_os_str(), target.as_os_str()]);
    let started = Instant::now();
    let answer: Answer = convert().output().unwrap().into();
    let duration = started.elapsed();
    answer.stdout();
    assert!(duration > Duration::from_millis(100), "too short to kill: {duration:?}");
    let new = fs::read(&target).unwrap();
    let old = fs::read(folder.map("old.dsm", &mono(full_info()))).unwrap();

    let [mut kept, mut replaced, mut left_overs] = [0; 3];
    for kill in 0..KILLS {
        fs::write(&target, &old).unwrap();
        let mut child = convert().stdout(std::process::Stdio::null()).spawn().unwrap();
        // To a third past its duration: some are done by then.
        std::thread::sleep(duration * kill * 13 / (KILLS * 10));
        child.kill().unwrap();
        child.wait().unwrap();
        let found = fs::read(&target).unwrap();
        let is_old = found == old;
        assert!(is_old || found == new, "kill {kill}: neither the old file nor the new");
        run!("verify", target).stdout();
        *(if is_old { &mut kept } else { &mut replaced }) += 1;
        let names = names(&folder.path("out"));
        let others = names.iter().filter(|name| *name != "map.dsm").count();
        // The last one killed; those before were removed by the next.
        assert!(others <= 1, "{names:?}");
        left_overs += others;
    }
    eprintln!(
        "{KILLS} kills over {duration:?}: {kept} times the old file, {replaced} times the new; \
         {left_overs} left a temporary file"
    );
    assert!(kept > 0 && left_overs > 0, "nothing was killed while it wrote");
    run!("convert", source, target).stdout();
    assert_eq!(names(&folder.path("out")), ["map.dsm"]);
}
