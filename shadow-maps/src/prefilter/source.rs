//! Where a prefiltered map's lists come from.

use dsm_core::Transmittance;
use dsm_trace::detail::LightFrame;

use super::lookup::{LevelLists, Levels};

/// A prefiltered map in memory, or in a file behind a tile cache.
pub trait PrefilteredSource: Sync {
    /// Mono or coloured.
    type Value: Transmittance;
    /// The error of a lookup; `Infallible` in memory.
    type Error;
    /// The lists, as one thread at a time reads them.
    type Lists: LevelLists<Self::Value, Error = Self::Error>;

    /// The frame of the map.
    fn frame(&self) -> &LightFrame;

    /// What is known of the levels.
    fn known(&self) -> &Levels;

    /// Calls `ask` with lists that no other thread uses meanwhile.
    fn with_lists<R>(&self, ask: impl FnOnce(&Self::Lists) -> R) -> R;
}

impl<M: PrefilteredSource> PrefilteredSource for &M {
    type Value = M::Value;
    type Error = M::Error;
    type Lists = M::Lists;

    fn frame(&self) -> &LightFrame {
        (**self).frame()
    }

    fn known(&self) -> &Levels {
        (**self).known()
    }

    fn with_lists<R>(&self, ask: impl FnOnce(&M::Lists) -> R) -> R {
        (**self).with_lists(ask)
    }
}
