//! `--version`, and what the build script knows of git.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::maps::Folder;
use crate::run;

fn manifest_folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn git(folder: &Path, arguments: &[&str]) -> Option<String> {
    let identity = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"];
    let output =
        Command::new("git").args(identity).args(arguments).current_dir(folder).output().ok()?;
    let answer = String::from_utf8(output.stdout).unwrap();
    output.status.success().then(|| answer.trim().to_owned())
}

#[test]
fn version_tells_program_format_and_commit() {
    let [major, minor] = dsm_io::detail::FORMAT_VERSION;
    let head = git(manifest_folder(), &["rev-parse", "--short=12", "HEAD"]);
    let is_ours = git(manifest_folder(), &["ls-files", "--error-unmatch", "Cargo.toml"]).is_some();
    let commit = match head.filter(|_| is_ours) {
        Some(head) => format!(", commit {head}"),
        None => String::new(),
    };
    let version = env!("CARGO_PKG_VERSION");
    let expected = format!("dsm-tools {version} (.dsm {major}.{minor}{commit})\n");
    assert_eq!(run!("--version").stdout(), expected);
}

/// Builds the build script.
fn build_script(folder: &Folder) -> PathBuf {
    let script = folder.path("build-script");
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let source = manifest_folder().join("build.rs");
    let mut build = Command::new(rustc);
    build.args(["--edition", "2024", "-o"]).arg(&script).arg(source);
    assert!(build.status().unwrap().success());
    script
}

#[test]
fn a_commit_is_told_in_a_checkout_only() {
    let folder = Folder::new();
    let script = build_script(&folder);
    let told = |place: &Path| {
        let mut call = Command::new(&script);
        // Nothing above the folder counts, whatever lies there.
        call.current_dir(place).env("GIT_CEILING_DIRECTORIES", folder.path(""));
        let output = call.output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let lines = String::from_utf8(output.stdout).unwrap();
        let commit =
            lines.lines().find_map(|line| line.strip_prefix("cargo::rustc-env=DSM_COMMIT="));
        commit.map(str::to_owned)
    };
    let place = folder.path("checkout");
    std::fs::create_dir(&place).unwrap();
    folder.write("checkout/Cargo.toml", "");
    assert_eq!(told(&place), None, "no checkout");
    if git(&place, &["init", "--quiet"]).is_none() {
        eprintln!("SKIPPED: there is no git here");
        return;
    }
    assert_eq!(told(&place), None, "the manifest is not part of it");
    git(&place, &["add", "."]).unwrap();
    assert_eq!(told(&place), None, "there is no commit");
    git(&place, &["commit", "--quiet", "-m", "first"]).unwrap();
    let first = told(&place).unwrap();
    assert_eq!(Some(&first), git(&place, &["rev-parse", "--short=12", "HEAD"]).as_ref());
    git(&place, &["commit", "--quiet", "--allow-empty", "-m", "second"]).unwrap();
    assert_ne!(told(&place), Some(first));
    folder.write("checkout/.cargo_vcs_info.json", "{}");
    assert_eq!(told(&place), None, "a package in someone's checkout");
}
