//! One way to make the same thing.

use std::fmt;

use crate::placement::Placement;

/// A scene's place, and what else no answer may depend on. An implementation is made
/// within a pool of [`Self::threads`] threads.
///
/// ```
/// use dsm_testkit::Trial;
///
/// assert_eq!(Trial::FIRST.placement.scale(), 1.0);
/// assert_eq!(Trial::FIRST.threads, 1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Trial {
    /// The placement of the scene.
    pub placement: Placement,
    /// The side of a tile, where there are tiles.
    pub tile_size: u32,
    /// Threads that work on it.
    pub threads: usize,
}

impl Trial {
    /// The scene as it is, in tiles of 64, on one thread.
    pub const FIRST: Self = Self { placement: Placement::HERE, tile_size: 64, threads: 1 };

    /// The scene in other tiles and on other threads: nothing may change, not a
    /// bit.
    pub(crate) fn alike() -> [Self; 2] {
        [Self { tile_size: 16, threads: 3, ..Self::FIRST }, Self { threads: 2, ..Self::FIRST }]
    }

    /// The scene of this radius elsewhere.
    pub(crate) fn elsewhere(radius: f64) -> impl Iterator<Item = Self> {
        Placement::elsewhere(radius).map(|placement| Self { placement, ..Self::FIRST })
    }

    /// Runs `work` on the trial's threads.
    pub(crate) fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> Result<R, String> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads).build();
        pool.map(|pool| pool.install(work)).map_err(|error| format!("no threads: {error}"))
    }
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { placement, tile_size, threads } = self;
        write!(
            f,
            "scaled by {}, moved by {}, tiles of {tile_size}, {threads} threads",
            placement.scale(),
            placement.shift()
        )
    }
}
