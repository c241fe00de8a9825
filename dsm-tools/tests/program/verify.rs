//! `verify`.

use std::process::Stdio;

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
    let file = |path: &std::path::Path| json!({"path": path, "ok": true, "errors": []});
    assert_eq!(told, json!({"ok": true, "files": [file(&mono), file(&rgb)]}));
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
    assert!(answer.stdout.contains("No such file"), "{answer:?}");
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
