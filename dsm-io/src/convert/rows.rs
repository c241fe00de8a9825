//! Some whole pixel rows of a source, and the function of each of their
//! pixels before compression.

use std::ops::Range;

use deep_exr::DeepRows;
use dsm_core::detail::{SumVertex, TransmittanceBuilder, TransmittanceFunction, VisibilityView};
use dsm_core::{RayHits, Transmittance, Vertex};

use super::deep_samples::collect_hits;
use super::report::ImportReport;
use crate::error::Result;
use crate::region::Region;

/// Some whole pixel rows.
pub(super) enum SourceRows<'a, T> {
    /// Samples of an image.
    Samples(DeepRows),
    /// Functions of a map.
    Stored(Region<'a, T>),
}

impl<T: Transmittance> SourceRows<'_, T> {
    /// Whether it is known without looking at any that these pixels are 1
    /// everywhere; rows count from the first of these.
    pub(super) fn is_clear(&self, columns: Range<u32>, rows: Range<u32>) -> bool {
        match self {
            Self::Samples(_) => false,
            Self::Stored(stored) => {
                let top = stored.rect().y;
                stored.is_clear(columns, top + rows.start..top + rows.end)
            }
        }
    }

    /// Computes the function of `pixel`, counted row by row from the first of
    /// the rows.
    pub(super) fn function(
        &self,
        pixel: usize,
        function: &mut ExactFunction<T>,
        report: &mut ImportReport,
    ) -> Result<()> {
        match self {
            Self::Samples(rows) => {
                function.hits.clear();
                collect_hits(rows, pixel, &mut function.hits, report)?;
                function.builder.build(&function.hits, &mut function.ray);
                function.is_stored = false;
            }
            Self::Stored(rows) => {
                let (rect, width) = (rows.rect(), rows.rect().width as usize);
                // Both are below the map's size.
                let (x, y) = ((pixel % width) as u32, rect.y + (pixel / width) as u32);
                let stored = rows.function(x, y).into_iter().flat_map(VisibilityView::vertices);
                function.stored.clear();
                let exact = |vertex: Vertex<T>| Vertex::new(vertex.z, vertex.value.to_sum());
                function.stored.extend(stored.map(exact));
                function.is_stored = true;
            }
        }
        Ok(())
    }
}

/// A pixel's function before compression, and the buffers to compute the next
/// one without an allocation.
pub(super) struct ExactFunction<T: Transmittance> {
    builder: TransmittanceBuilder<T>,
    hits: RayHits<T>,
    ray: TransmittanceFunction<T>,
    stored: Vec<SumVertex<T>>,
    is_stored: bool,
}

impl<T: Transmittance> ExactFunction<T> {
    /// Curved stretches will become chords that are off by at most
    /// `chord_error`.
    pub(super) fn new(chord_error: f64) -> Self {
        Self {
            builder: TransmittanceBuilder::new(chord_error),
            hits: RayHits::default(),
            ray: TransmittanceFunction::default(),
            stored: Vec::new(),
            is_stored: false,
        }
    }

    /// Its vertices, front to back.
    pub(super) fn vertices(&self) -> &[SumVertex<T>] {
        if self.is_stored { &self.stored } else { self.ray.vertices() }
    }

    /// Whether chords stand for curved stretches.
    pub(super) fn is_curved(&self) -> bool {
        !self.is_stored && self.ray.is_curved()
    }
}
