//! Where an attenuation map's layers come from.

use dsm_core::Transmittance;
use dsm_trace::detail::LightFrame;

use crate::prefilter::lists::FragmentList;

/// An attenuation map in memory, or in a file behind a tile cache.
pub trait AttenuationSource: Sync {
    /// Mono or coloured.
    type Value: Transmittance;
    /// The error of a lookup; `Infallible` in memory.
    type Error;
    /// The layers, as one thread at a time reads them.
    type Lists: TexelLists<Self::Value, Error = Self::Error>;

    /// The frame of the map.
    fn frame(&self) -> &LightFrame;

    /// Calls `ask` with layers that no other thread uses meanwhile.
    fn with_lists<R>(&self, ask: impl FnOnce(&Self::Lists) -> R) -> R;
}

/// The layers of texels.
pub trait TexelLists<T> {
    /// The error of a lookup.
    type Error;

    /// Calls `look` with the layers of a texel of the map.
    ///
    /// # Errors
    ///
    /// What keeps its tile from being read.
    fn with_list<R>(
        &self,
        texel: [u32; 2],
        look: impl FnOnce(FragmentList<'_, T>) -> R,
    ) -> Result<R, Self::Error>;
}
