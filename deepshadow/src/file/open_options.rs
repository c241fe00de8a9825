//! Options of opening maps.

use dsm_io::Limits;
#[cfg(doc)]
use dsm_io::detail::Container;
use dsm_io::detail::TileCache;
use dsm_io::dsm_remote::RemoteOptions;

/// Bytes of tiles that are kept at hand unless another budget is set: the tiles of
/// large maps come and go, and small ones stay whole.
const TILE_BYTES: u64 = 1 << 30;

/// Options of opening maps: the tile cache that they share, and the limits of
/// what a file may require.
///
/// ```no_run
/// use deepshadow::OpenOptions;
///
/// // The key light and the rim light within 256 MiB together.
/// let options = OpenOptions::new().with_cache_bytes(256 << 20);
/// let (key, rim) = (options.open("key.dsm")?, options.open("rim.dsm")?);
/// # Ok::<(), deepshadow::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct OpenOptions {
    pub(crate) cache: TileCache,
    pub(crate) limits: Limits,
    pub(crate) is_mapped: bool,
    /// Of addresses; those of the environment if none were set.
    pub(crate) remote: Option<RemoteOptions>,
}

impl OpenOptions {
    /// A tile cache of 1 GiB, and the usual limits.
    #[must_use]
    pub fn new() -> Self {
        Self {
            cache: TileCache::new(TILE_BYTES),
            limits: Limits::default(),
            is_mapped: false,
            remote: None,
        }
    }

    /// A new tile cache that keeps at most so many bytes, for all maps that are
    /// opened with these options or clones of them.
    #[must_use]
    pub fn with_cache_bytes(self, bytes: u64) -> Self {
        self.with_cache(TileCache::new(bytes))
    }

    /// Sets the tile cache.
    #[must_use]
    pub fn with_cache(self, cache: TileCache) -> Self {
        Self { cache, ..self }
    }

    /// Sets the limits of what a file may require.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// Maps files into memory instead of reading them: only for files that nobody
    /// writes to meanwhile ([`Container::open_mapped`]).
    #[must_use]
    pub fn with_mapping(self, is_mapped: bool) -> Self {
        Self { is_mapped, ..self }
    }

    /// Sets how maps in object stores are read: how patiently, and with which cache on
    /// the local disk. Unless set, the environment says.
    #[must_use]
    pub fn with_remote(self, remote: RemoteOptions) -> Self {
        Self { remote: Some(remote), ..self }
    }

    /// The tile cache, whose statistics tell hits and misses.
    #[must_use]
    pub const fn cache(&self) -> &TileCache {
        &self.cache
    }
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self::new()
    }
}
