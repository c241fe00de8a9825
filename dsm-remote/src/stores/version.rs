//! Which version of an object an answer is of.

use std::time::SystemTime;

use object_store::{GetOptions, ObjectMeta};

/// What tells one version of an object from another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Version {
    etag: Option<String>,
    modified: Option<SystemTime>,
    length: u64,
}

impl Version {
    pub(super) fn of(meta: &ObjectMeta) -> Self {
        let modified = SystemTime::from(meta.last_modified);
        Self {
            etag: meta.e_tag.clone().filter(|etag| !etag.is_empty()),
            // The clients' value for an answer that tells no time.
            modified: (modified != SystemTime::UNIX_EPOCH).then_some(modified),
            length: meta.size,
        }
    }

    pub(super) const fn length(&self) -> u64 {
        self.length
    }

    /// Whether an answer is of this version: of the same ETag, or where there is none, of
    /// the same time; and of the same length.
    pub(super) fn is_of(&self, meta: &ObjectMeta) -> bool {
        let other = Self::of(meta);
        let same = match (&self.etag, &other.etag) {
            (Some(own), Some(other)) => own == other,
            (None, None) => self.modified == other.modified,
            _ => false,
        };
        same && self.length == other.length
    }

    /// Asks the store to answer for this version alone.
    pub(super) fn condition(&self, options: &mut GetOptions, meta: &ObjectMeta) {
        match &self.etag {
            // Weak tags never match a condition (RFC 9110, 13.1.1); answers are compared.
            Some(etag) if !etag.starts_with("W/") => options.if_match = Some(etag.clone()),
            Some(_) => {}
            None if self.modified.is_some() => {
                options.if_unmodified_since = Some(meta.last_modified);
            }
            None => {}
        }
    }

    /// A name for caches: none for a version that is told by its length alone.
    pub(super) fn key(&self) -> Option<String> {
        let Self { etag, modified, length } = self;
        match (etag, modified) {
            (Some(etag), _) => Some(format!("{etag} {length}")),
            (None, Some(modified)) => {
                let since = modified.duration_since(SystemTime::UNIX_EPOCH).ok()?;
                Some(format!("{} {length}", since.as_nanos()))
            }
            (None, None) => None,
        }
    }

    /// What cannot be told of a file that is replaced while it is read.
    pub(super) const fn remark(&self) -> Option<&'static str> {
        match (&self.etag, &self.modified) {
            (Some(_), _) => None,
            (None, Some(_)) => Some(
                "the server tells no ETag: a file of the same length that replaces this one within a second is found by checksums alone",
            ),
            (None, None) => Some(
                "the server tells neither an ETag nor a time: a file of the same length that replaces this one is found by checksums alone",
            ),
        }
    }
}
