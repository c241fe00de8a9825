//! Numbers of frames in the names of files.

use std::path::{Path, PathBuf};

/// The path with each run of `#` replaced by a frame's number, of at least as many digits:
/// `hair.####.abc` is `hair.0012.abc` in frame 12.
///
/// ```
/// use dsm_scene::detail::frame_path;
///
/// assert_eq!(frame_path("hair.####.toml".as_ref(), 12).to_str(), Some("hair.0012.toml"));
/// assert_eq!(frame_path("#/a.##.ply".as_ref(), 123).to_str(), Some("123/a.123.ply"));
/// ```
#[must_use]
pub fn frame_path(path: &Path, frame: u32) -> PathBuf {
    let Some(name) = path.to_str() else { return path.to_owned() };
    let (mut replaced, mut digits) = (String::with_capacity(name.len()), 0);
    let flush = |replaced: &mut String, digits: &mut usize| {
        if *digits > 0 {
            replaced.push_str(&format!("{frame:0width$}", width = *digits));
            *digits = 0;
        }
    };
    for character in name.chars() {
        if character == '#' {
            digits += 1;
            continue;
        }
        flush(&mut replaced, &mut digits);
        replaced.push(character);
    }
    flush(&mut replaced, &mut digits);
    PathBuf::from(replaced)
}

/// Whether a path has a place for a frame's number.
#[must_use]
pub fn has_frame(path: &Path) -> bool {
    path.to_str().is_some_and(|name| name.contains('#'))
}
