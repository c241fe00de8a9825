//! Version of the program.

use std::sync::LazyLock;

/// Version of the program and of the format, and the commit of a build from a
/// checkout.
pub(super) fn version() -> &'static str {
    static VERSION: LazyLock<String> = LazyLock::new(|| {
        let [major, minor] = deepshadow::files::detail::FORMAT_VERSION;
        let commit = option_env!("DSM_COMMIT").map(|commit| format!(", commit {commit}"));
        let commit = commit.unwrap_or_default();
        format!("{} (.dsm {major}.{minor}{commit})", env!("CARGO_PKG_VERSION"))
    });
    &VERSION
}
