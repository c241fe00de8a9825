//! Tells the program the commit that it is built from, in a checkout with git, and leaves names
//! of functions out of releases.

use std::env;
use std::io::{self, Write};
use std::path::Path;
use std::process::Command;

/// What git answers, if it is there and has an answer.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let answer = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| answer.trim().to_owned())
}

/// The commit, unless this is a package that lies unpacked in someone else's
/// checkout: there the manifest is unknown to git, or stands beside Cargo's note
/// of where the package comes from.
fn commit() -> Option<String> {
    if Path::new(".cargo_vcs_info.json").exists() {
        return None;
    }
    git(&["ls-files", "--error-unmatch", "Cargo.toml"])?;
    git(&["rev-parse", "--short=12", "HEAD"])
}

fn main() -> io::Result<()> {
    let mut cargo = io::stdout();
    writeln!(cargo, "cargo::rerun-if-changed=build.rs")?;
    // Names of functions are a seventh of the program, and only backtraces show them. The option to
    // strip all would be undone by the compiler's own, which comes later and strips less.
    let is = |name: &str, value: &str| env::var(name).is_ok_and(|found| found == value);
    if is("PROFILE", "release") && is("CARGO_CFG_TARGET_OS", "linux") {
        writeln!(cargo, "cargo::rustc-link-arg-bins=-Wl,--discard-all")?;
    }
    let Some(commit) = commit() else { return Ok(()) };
    writeln!(cargo, "cargo::rustc-env=DSM_COMMIT={commit}")?;
    // The log of HEAD changes with each commit, HEAD itself with each checkout.
    for file in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--git-path", file]);
        if let Some(path) = path.filter(|path| Path::new(path).exists()) {
            writeln!(cargo, "cargo::rerun-if-changed={path}")?;
        }
    }
    Ok(())
}
