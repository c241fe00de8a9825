//! Puts pixels together that come from elsewhere, column by column.

use dsm_core::Transmittance;
use dsm_core::detail::{PixelLists, VisibilityView};

use crate::error::{Error, Result, check_limit};

/// The columns of [`PixelLists`] while they are put together.
#[derive(Default)]
pub(crate) struct Columns {
    starts: Vec<u32>,
    value_starts: Vec<u32>,
    z: Vec<f32>,
    values: Vec<f32>,
}

impl Columns {
    /// Adds the next pixel, its columns as they are.
    pub(crate) fn push<T: Transmittance>(&mut self, function: VisibilityView<'_, T>) -> Result<()> {
        self.mark_start();
        self.z.extend_from_slice(function.depths());
        self.values.extend_from_slice(function.columns());
        check_limit("values of one map in memory", self.values.len() as u64, u32::MAX.into())
    }

    /// Notes where a pixel starts. There are at least as many values as
    /// vertices, and [`Self::push`] holds them below 2³².
    fn mark_start(&mut self) {
        self.starts.push(self.z.len() as u32);
        self.value_starts.push(self.values.len() as u32);
    }

    /// The pixels, `width` × `height` of them.
    pub(crate) fn finish<T: Transmittance>(
        mut self,
        width: u32,
        height: u32,
    ) -> Result<PixelLists<T>> {
        self.mark_start();
        if T::CHANNELS == 1 {
            self.value_starts = Vec::new();
        }
        PixelLists::new((width, height), self.starts, self.value_starts, self.z, self.values)
            .map_err(Error::from)
    }
}
