//! What to do about an error that newcomers make, after its line.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::Error;
use deepshadow::files::Error as FileError;
use deepshadow::scene::Error as SceneError;

/// The remedy of an error, if one is known.
pub(crate) fn hint(error: &Error) -> Option<String> {
    let mut not_found = false;
    for cause in error.chain() {
        let io = cause.downcast_ref::<std::io::Error>();
        not_found |= io.is_some_and(|error| error.kind() == ErrorKind::NotFound);
    }
    let known = error.chain().find_map(|cause| {
        if let Some(error) = cause.downcast_ref::<deepshadow::Error>() {
            return match error {
                deepshadow::Error::File(error) => of_file(error, None, not_found),
                deepshadow::Error::Scene(error) => of_scene(error, None, not_found),
                deepshadow::Error::Query { reason, .. } => of_query(reason),
                _ => None,
            };
        }
        let of_file = |error| of_file(error, None, not_found);
        let of_scene = |error| of_scene(error, None, not_found);
        cause
            .downcast_ref::<FileError>()
            .and_then(of_file)
            .or_else(|| cause.downcast_ref::<SceneError>().and_then(of_scene))
    });
    known.or_else(|| not_found.then(|| NOTHING.to_owned()))
}

/// What to do about a name that nothing has.
const NOTHING: &str = "nothing has this name: check it, and the folder that you are in";

/// The method of a map that is asked by another, where the reason does not name it.
fn of_query(reason: &str) -> Option<String> {
    let is_traced = reason.contains("are traced") && !reason.contains("--method");
    is_traced.then(|| "--method trace reads this one".to_owned())
}

fn of_file(error: &FileError, path: Option<&Path>, not_found: bool) -> Option<String> {
    Some(match error {
        FileError::File(inner) => return of_file(&inner.error, Some(&inner.path), not_found),
        FileError::Io { .. } if not_found => missing(path?),
        FileError::Path(_) if path?.is_dir() => "it is a folder: name a file in it".to_owned(),
        FileError::NotDsm(_) if path?.is_dir() => "it is a folder: name a file in it".to_owned(),
        FileError::NotDsm(_) => {
            "a map is made by `dsm-tools bake SCENE -o MAP.dsm`, or of a deep .exr by `convert`"
                .to_owned()
        }
        FileError::Truncated { .. } => "it was not copied whole: copy or bake it again".to_owned(),
        FileError::Checksum { .. } => "it was damaged on its way: copy or bake it again".to_owned(),
        FileError::Kind { found, .. } => format!(
            "this takes maps of kind deep (`bake --kind deep`); of kind {found} `inspect`, `lookup` and `verify` read"
        ),
        FileError::Mismatch(reason) if reason.starts_with("the sizes differ") => {
            "bake them with one --resolution".to_owned()
        }
        _ => return None,
    })
}

fn of_scene(error: &SceneError, path: Option<&Path>, not_found: bool) -> Option<String> {
    Some(match error {
        SceneError::File(inner) => return of_scene(&inner.error, Some(&inner.path), not_found),
        SceneError::Io { .. } if not_found => missing(path?),
        SceneError::UnknownBuiltin { name, known } => {
            let near = known.iter().min_by_key(|known| distance(name, known))?;
            if distance(name, near) > 3 {
                return None;
            }
            format!("did you mean builtin:{near}?")
        }
        SceneError::UnknownFormat { .. } if path.is_some_and(Path::is_dir) => {
            "it is a folder: name a file in it".to_owned()
        }
        SceneError::UnknownFormat { .. } => {
            "a scene is a .toml, a model, or builtin:NAME, such as builtin:hairball".to_owned()
        }
        SceneError::Malformed { reason, .. } => return unknown_field(reason),
        _ => return None,
    })
}

/// The key that may have been meant, of the message of a scene file's reader.
fn unknown_field(reason: &str) -> Option<String> {
    let (_, rest) = reason.split_once("unknown field `")?;
    let (wrong, rest) = rest.split_once('`')?;
    let known = rest.split('`').skip(1).step_by(2);
    let near = known.min_by_key(|known| distance(wrong, known))?;
    (distance(wrong, near) <= 2).then(|| format!("did you mean {near}?"))
}

/// What to do about a file that is not there: a name in the same folder that is nearly the same.
fn missing(path: &Path) -> String {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    if !folder.is_dir() {
        return format!("there is no folder {}", folder.display());
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let names = std::fs::read_dir(&folder).into_iter().flatten().flatten();
    let names = names.map(|entry| entry.file_name().to_string_lossy().into_owned());
    // Two of one distance: the first by name, wherever the system begins.
    let near = names.map(|other| (distance(&name, &other), other)).min();
    match near {
        Some((apart, near)) if apart <= 2 && apart < name.chars().count() / 2 => {
            format!("did you mean {}?", path.with_file_name(near).display())
        }
        _ => NOTHING.to_owned(),
    }
}

/// Letters to insert, delete or replace until one word is the other, two that are swapped for
/// one. Long words count as far from each other. O(1).
fn distance(a: &str, b: &str) -> usize {
    const LONGEST: usize = 64;
    let [a, b] = [a, b].map(|word| word.chars().collect::<Vec<_>>());
    if a.len().max(b.len()) > LONGEST {
        return LONGEST;
    }
    let mut rows = vec![(0..=b.len()).collect::<Vec<_>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = replaced.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_as_far_apart_as_their_letters() {
        for (a, b, apart) in [
            ("fow", "fov", 1),
            ("hairbal", "hairball", 1),
            ("", "abc", 3),
            ("ab", "ba", 1),
            ("x", "x", 0),
        ] {
            assert_eq!((distance(a, b), distance(b, a)), (apart, apart), "{a} {b}");
        }
    }

    #[test]
    fn files_that_are_nearly_called_so_are_named() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("hair.dsm"), "").unwrap();
        let told = missing(&folder.path().join("hari.dsm"));
        assert!(told.ends_with("hair.dsm?"), "{told}");
        let told = missing(&folder.path().join("smoke.toml"));
        assert!(told.starts_with("nothing has this name"), "{told}");
        let told = missing(&folder.path().join("no/hair.dsm"));
        assert!(told.starts_with("there is no folder"), "{told}");
    }

    #[test]
    fn keys_that_were_meant_are_named() {
        let reason = "unknown field `fow`, expected one of `eye`, `fov`, `size`";
        assert_eq!(unknown_field(reason).as_deref(), Some("did you mean fov?"));
        assert_eq!(unknown_field("unknown field `colour`, expected `eye`"), None);
        assert_eq!(unknown_field("a number is missing"), None);
    }
}
