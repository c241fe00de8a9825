//! Settings of reading and writing remote files.

use std::path::PathBuf;
use std::time::Duration;

use crate::error::{Error, Result};

/// Settings of remote files: how long to wait, how often to try again, how much to read
/// ahead, and a cache on the local disk.
///
/// Credentials and endpoints are the environment's, as `object_store` reads them.
///
/// ```
/// use std::time::Duration;
/// use dsm_remote::RemoteOptions;
///
/// let options = RemoteOptions::new()
///     .with_timeout(Duration::from_secs(5))
///     .with_retries(2)
///     .with_disk_cache("/var/tmp/maps", 8 << 30);
/// assert_eq!(options.disk_cache.map(|(_, bytes)| bytes), Some(8 << 30));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RemoteOptions {
    /// The time that an attempt has for each MiB that it asks for, or a part of one.
    /// Default 30 s.
    pub timeout: Duration,
    /// How often a read is tried again after it failed: what came before is kept, and each
    /// wait is twice as long as the one before, from 0.1 s to 5 s. Default 6.
    pub retries: u32,
    /// The most bytes that are read ahead of reads that follow each other. Default 4 MiB.
    pub read_ahead: u64,
    /// A folder for what was read, shared with other processes, and the most bytes that it
    /// may hold; none by default.
    pub disk_cache: Option<(PathBuf, u64)>,
}

/// The budget of a cache for which none is set: 4 GiB.
const CACHE_BYTES: u64 = 4 << 30;

impl RemoteOptions {
    /// The defaults, and no cache on the disk.
    #[must_use]
    pub const fn new() -> Self {
        Self { timeout: Duration::from_secs(30), retries: 6, read_ahead: 4 << 20, disk_cache: None }
    }

    /// Settings from the environment: `DEEPSHADOW_REMOTE_TIMEOUT` (seconds),
    /// `DEEPSHADOW_REMOTE_RETRIES`, `DEEPSHADOW_REMOTE_CACHE` (a folder) and
    /// `DEEPSHADOW_REMOTE_CACHE_BYTES` (4 GiB if missing). What is not set is as in
    /// [`Self::new`].
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for a value that is none.
    pub fn from_env() -> Result<Self> {
        Self::from_variables(|name| std::env::var_os(name))
    }

    fn from_variables(get: impl Fn(&str) -> Option<std::ffi::OsString>) -> Result<Self> {
        fn number<T: std::str::FromStr>(
            value: Option<std::ffi::OsString>,
            name: &'static str,
            reason: &'static str,
        ) -> Result<Option<T>> {
            let Some(value) = value.filter(|value| !value.is_empty()) else { return Ok(None) };
            let parsed = value.to_str().and_then(|text| text.trim().parse().ok());
            parsed.map(Some).ok_or(Error::Setting { name, reason })
        }
        let mut options = Self::new();
        let name = "DEEPSHADOW_REMOTE_TIMEOUT";
        let reason = "must be a number of seconds above 0, at most a day";
        if let Some(seconds) = number::<f64>(get(name), name, reason)? {
            // Longer than a day is a slip, and what isn't finite no time.
            if !(seconds > 0.0 && seconds <= 86_400.0) {
                return Err(Error::Setting { name, reason });
            }
            options.timeout = Duration::from_secs_f64(seconds);
        }
        let name = "DEEPSHADOW_REMOTE_RETRIES";
        if let Some(retries) = number(get(name), name, "must be a whole number from 0 on")? {
            options.retries = retries;
        }
        let name = "DEEPSHADOW_REMOTE_CACHE_BYTES";
        let bytes = number(get(name), name, "must be a whole number of bytes")?;
        let folder = get("DEEPSHADOW_REMOTE_CACHE").filter(|folder| !folder.is_empty());
        options.disk_cache = folder.map(|folder| (folder.into(), bytes.unwrap_or(CACHE_BYTES)));
        Ok(options)
    }

    /// Sets [`Self::timeout`].
    #[must_use]
    pub const fn with_timeout(mut self, timeout: Duration) -> Self {
        self.timeout = timeout;
        self
    }

    /// Sets [`Self::retries`].
    #[must_use]
    pub const fn with_retries(mut self, retries: u32) -> Self {
        self.retries = retries;
        self
    }

    /// Sets [`Self::read_ahead`]: 0 reads what is asked for alone.
    #[must_use]
    pub const fn with_read_ahead(mut self, bytes: u64) -> Self {
        self.read_ahead = bytes;
        self
    }

    /// Sets [`Self::disk_cache`].
    #[must_use]
    pub fn with_disk_cache(mut self, folder: impl Into<PathBuf>, bytes: u64) -> Self {
        self.disk_cache = Some((folder.into(), bytes));
        self
    }
}

impl Default for RemoteOptions {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(variables: &[(&str, &str)]) -> Result<RemoteOptions> {
        RemoteOptions::from_variables(|name| {
            variables.iter().find(|(set, _)| *set == name).map(|(_, value)| value.into())
        })
    }

    #[test]
    fn the_environment_is_read_and_checked() {
        assert_eq!(read(&[]).unwrap(), RemoteOptions::new());
        let set = read(&[
            ("DEEPSHADOW_REMOTE_TIMEOUT", "0.5"),
            ("DEEPSHADOW_REMOTE_RETRIES", "2"),
            ("DEEPSHADOW_REMOTE_CACHE", "/tmp/maps"),
            ("DEEPSHADOW_REMOTE_CACHE_BYTES", "1000"),
        ]);
        let expected = RemoteOptions::new()
            .with_timeout(Duration::from_millis(500))
            .with_retries(2)
            .with_disk_cache("/tmp/maps", 1000);
        assert_eq!(set.unwrap(), expected);
        let cached = read(&[("DEEPSHADOW_REMOTE_CACHE", "maps")]).unwrap();
        assert_eq!(cached.disk_cache, Some(("maps".into(), CACHE_BYTES)));
        for (name, wrong) in [
            ("DEEPSHADOW_REMOTE_TIMEOUT", "0"),
            ("DEEPSHADOW_REMOTE_TIMEOUT", "NaN"),
            ("DEEPSHADOW_REMOTE_TIMEOUT", "inf"),
            ("DEEPSHADOW_REMOTE_TIMEOUT", "soon"),
            ("DEEPSHADOW_REMOTE_RETRIES", "-1"),
            ("DEEPSHADOW_REMOTE_CACHE_BYTES", "4G"),
        ] {
            let error = read(&[(name, wrong)]).unwrap_err().to_string();
            assert!(error.starts_with(name), "{error}");
        }
    }
}
