//! Addresses of remote files.

use std::borrow::Cow;
use std::path::Path;

/// The schemes that are addresses. Anything else is a path.
const SCHEMES: [&str; 9] = ["s3", "s3a", "gs", "az", "azure", "abfs", "abfss", "https", "http"];

/// An address in its parts, as far as they matter before a client sees it.
pub(crate) struct Parts<'a> {
    pub(crate) scheme: &'a str,
    pub(crate) authority: &'a str,
    /// The path without its first slash.
    pub(crate) path: &'a str,
    /// What follows a question mark or number sign, with it.
    pub(crate) rest: &'a str,
}

impl<'a> Parts<'a> {
    /// The parts of an address of a known scheme.
    pub(crate) fn of(text: &'a str) -> Option<Self> {
        let (scheme, after) = text.split_once("://")?;
        if !SCHEMES.iter().any(|known| known.eq_ignore_ascii_case(scheme)) {
            return None;
        }
        let (before, rest) = after.split_at(after.find(['?', '#']).unwrap_or(after.len()));
        let (authority, path) = before.split_once('/').unwrap_or((before, ""));
        Some(Self { scheme, authority, path, rest })
    }

    /// Whether what precedes an @ names a container, not a user.
    fn names_container(&self) -> bool {
        self.scheme.to_ascii_lowercase().starts_with("abfs")
    }

    /// A user and password, which are secrets, before the host.
    #[cfg(feature = "stores")]
    pub(crate) fn has_user(&self) -> bool {
        self.authority.contains('@') && !self.names_container()
    }
}

/// Whether a path is an address of a remote file: begins with `s3://`, `s3a://`, `gs://`,
/// `az://`, `azure://`, `abfs://`, `abfss://`, `https://` or `http://`.
///
/// ```
/// assert!(dsm_remote::is_url("s3://maps/key.dsm".as_ref()));
/// assert!(!dsm_remote::is_url("maps/key.dsm".as_ref()));
/// ```
#[must_use]
pub fn is_url(path: &Path) -> bool {
    path.to_str().is_some_and(|text| Parts::of(text).is_some())
}

/// A path as messages show it: of an address neither user and password nor what follows a
/// question mark, which may be a signature.
///
/// ```
/// let shown = dsm_remote::shown("https://me:secret@host/map.dsm?sig=1".as_ref());
/// assert_eq!(shown.to_str(), Some("https://host/map.dsm"));
/// ```
#[must_use]
pub fn shown(path: &Path) -> Cow<'_, Path> {
    let Some(parts) = path.to_str().and_then(Parts::of) else { return Cow::Borrowed(path) };
    let host = match parts.authority.rsplit_once('@') {
        Some((container, host)) if parts.names_container() && !container.contains(':') => {
            return match parts.rest {
                "" => Cow::Borrowed(path),
                _ => Cow::Owned(
                    format!("{}://{container}@{host}/{}", parts.scheme, parts.path).into(),
                ),
            };
        }
        Some((_, host)) => host,
        None if parts.rest.is_empty() => return Cow::Borrowed(path),
        None => parts.authority,
    };
    Cow::Owned(format!("{}://{host}/{}", parts.scheme, parts.path).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_told_from_paths() {
        for url in ["s3://b/k", "S3://b/k", "gs://b/k", "http://h/f", "abfss://c@a.host/f"] {
            assert!(is_url(url.as_ref()), "{url}");
        }
        for path in
            ["s3:/b/k", "map.dsm", "file:///map.dsm", "C:\\maps\\map.dsm", "://", "a/s3://b"]
        {
            assert!(!is_url(path.as_ref()), "{path}");
        }
    }

    #[test]
    fn secrets_are_not_shown() {
        for (url, expected) in [
            ("https://h/f.dsm?X-Amz-Signature=secret", "https://h/f.dsm"),
            ("https://h?secret", "https://h/"),
            ("https://h/f#secret", "https://h/f"),
            ("https://me:secret@h/f", "https://h/f"),
            ("https://secret@secret@h/f", "https://h/f"),
            ("s3://key:secret@b/f@2.dsm", "s3://b/f@2.dsm"),
            ("abfss://c@a.host/f?sig=secret", "abfss://c@a.host/f"),
            ("abfss://c:secret@a.host/f", "abfss://a.host/f"),
            ("abfss://c@a.host/f", "abfss://c@a.host/f"),
            ("s3://b/f", "s3://b/f"),
            ("folder/f?secret", "folder/f?secret"),
        ] {
            assert_eq!(shown(url.as_ref()).to_str(), Some(expected), "{url}");
        }
    }
}
