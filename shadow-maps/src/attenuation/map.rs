//! Attenuation maps in memory.

use std::convert::Infallible;

use dsm_core::detail::Result;
use dsm_core::{Error, Transmittance};
use dsm_io::detail::KindReader;
use dsm_trace::detail::LightFrame;

use super::cached::frame_of;
use super::source::{AttenuationSource, TexelLists};
use super::store::Attenuation;
use crate::prefilter::lists::{FragmentList, FragmentLists};

/// A layered attenuation map (Agrawala et al. 2000, §4) in memory.
#[derive(Clone, Debug)]
pub struct AttenuationMap<T> {
    frame: LightFrame,
    lists: FragmentLists<T>,
}

impl<T: Transmittance> AttenuationMap<T> {
    /// The map of layers with this frame, as
    /// [`AttenuationBuilder`](super::builder::AttenuationBuilder) makes them.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if there is not a list a texel.
    pub fn new(frame: LightFrame, lists: FragmentLists<T>) -> Result<Self> {
        if lists.size() != frame.size() {
            let reason = "there must be a list a texel of the map";
            return Err(Error::Setting { setting: "lists", reason });
        }
        Ok(Self { frame, lists })
    }

    /// Reads a whole map, row by row of tiles. O(layers).
    ///
    /// # Errors
    ///
    /// [`Error::Channels`](dsm_io::Error::Channels) for a map of another number of
    /// channels, [`Error::Limit`](dsm_io::Error::Limit) for one that is too large, or what
    /// is wrong with a tile.
    pub fn read(reader: &KindReader<Attenuation>) -> dsm_io::detail::Result<Self> {
        reader.check_in_memory(0)?;
        let frame = reader.container().in_file(frame_of(reader).map_err(Into::into))?;
        let mut lists = FragmentLists::new(frame.size());
        reader.for_each_pixel::<T>(0, |tile, pixel| {
            let list = tile.list(pixel);
            let layers = list.w.iter().zip(list.opacities);
            layers.for_each(|(&w, &share)| lists.push(w, share));
            Ok(lists.finish_texel()?)
        })?;
        Ok(Self { frame, lists })
    }

    /// The layers of every texel: a w and an attenuation each.
    #[must_use]
    pub const fn lists(&self) -> &FragmentLists<T> {
        &self.lists
    }
}

impl<T: Transmittance> TexelLists<T> for AttenuationMap<T> {
    type Error = Infallible;

    #[inline]
    fn with_list<R>(
        &self,
        [x, y]: [u32; 2],
        look: impl FnOnce(FragmentList<'_, T>) -> R,
    ) -> Result<R, Infallible> {
        Ok(look(self.lists.at(x.into(), y.into())))
    }
}

impl<T: Transmittance> AttenuationSource for AttenuationMap<T> {
    type Value = T;
    type Error = Infallible;
    type Lists = Self;

    fn frame(&self) -> &LightFrame {
        &self.frame
    }

    fn with_lists<R>(&self, ask: impl FnOnce(&Self) -> R) -> R {
        ask(self)
    }
}
