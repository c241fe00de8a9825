//! Compressors of whole functions, and the choice among them.

use serde::{Deserialize, Deserializer, Serialize};

use super::greedy;
use super::min_link::compressor::MinLinkCompressor;
use super::side::Side;
use crate::error::{Error, Result};
use crate::tolerance::Tolerance;
use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// A compressor of visibility functions under an L∞ bound, which keeps its memory from
/// one function to the next.
pub trait Compressor<T: Transmittance> {
    /// Passes the vertices of a V′ with |V′ − V| ≤ ε, in `f32` values, to `emit`,
    /// for the V of `vertices`, which keep the invariant of visibility functions
    /// and end with V(∞): V′ ends with it too, rounded, and keeps the invariant.
    fn compress(
        &mut self,
        tolerance: Tolerance,
        vertices: &[SumVertex<T>],
        emit: &mut impl FnMut(Vertex<T>),
    );
}

/// The algorithm that chooses the vertices of V′.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum CompressionMethod {
    /// One pass with constant state ([`GreedyCompressor`](greedy::GreedyCompressor)):
    /// the fastest.
    Greedy,
    /// The fewest vertices ([`MinLinkCompressor`]): the smallest files.
    #[default]
    MinLink,
}

impl CompressionMethod {
    /// The name, as files and programs have it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Greedy => "greedy",
            Self::MinLink => "min-link",
        }
    }
}

/// The choice of a compressor, for bakes, conversions and mip levels.
///
/// ```
/// use dsm_core::{Compression, CompressionMethod, Side, Tolerance, Vertex};
/// use dsm_core::detail::Compressor;
///
/// // Ten sheets that each stop a twentieth of the light.
/// let left = |sheets: u8| [f64::from(20 - sheets) / 20.0];
/// let steps = (1..=10_u8).flat_map(|sheet| {
///     [left(sheet - 1), left(sheet)].map(|value| Vertex::new(f32::from(sheet), value))
/// });
/// let exact: Vec<_> = steps.collect();
/// let compressed = |compression: Compression| {
///     let mut compressed: Vec<Vertex<f32>> = Vec::new();
///     let mut compressor = compression.compressor();
///     compressor.compress(Tolerance::new(0.06)?, &exact, &mut |vertex| compressed.push(vertex));
///     Ok::<_, dsm_core::Error>(compressed)
/// };
/// let greedy = compressed(Compression::new(CompressionMethod::Greedy))?;
/// assert_eq!(greedy, [Vertex::new(1.0, 1.0), Vertex::new(10.0, 0.5)]);
/// // Nowhere darker than the sheets.
/// let min_link = Compression::new(CompressionMethod::MinLink);
/// let lighter = compressed(min_link.with_side(Side::Lighter))?;
/// assert!(lighter.iter().all(|vertex| f64::from(vertex.value) >= 0.5));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Compression {
    /// The algorithm.
    pub method: CompressionMethod,
    /// The side of V that V′ keeps to.
    #[serde(default)]
    pub side: Side,
}

impl Compression {
    /// Within the tolerance on both sides of V.
    #[must_use]
    pub const fn new(method: CompressionMethod) -> Self {
        Self { method, side: Side::Both }
    }

    /// Keeps to one side of V.
    #[must_use]
    pub const fn with_side(self, side: Side) -> Self {
        Self { side, ..self }
    }

    /// Refuses a side that the method can't keep to.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for one side of the greedy method.
    pub fn check(self) -> Result<()> {
        if self.method == CompressionMethod::Greedy && self.side != Side::Both {
            let reason = "one side alone needs the method min-link";
            return Err(Error::Setting { setting: "side", reason });
        }
        Ok(())
    }

    /// This, as the header of a map states it: not for the greedy method.
    #[must_use]
    pub fn stated(self) -> Option<Self> {
        (self.method != CompressionMethod::Greedy).then_some(self)
    }

    /// That of a map whose header states this.
    #[must_use]
    pub fn of_stated(stated: Option<Self>) -> Self {
        stated.unwrap_or(Self::new(CompressionMethod::Greedy))
    }

    /// A compressor of this kind. One that was asked for one side and can't keep to it
    /// (see [`Self::check`]) keeps to both.
    #[must_use]
    pub fn compressor<T: Transmittance>(self) -> ChosenCompressor<T> {
        ChosenCompressor(match self.method {
            CompressionMethod::Greedy => Chosen::Greedy,
            CompressionMethod::MinLink => {
                Chosen::MinLink(Box::new(MinLinkCompressor::new(self.side)))
            }
        })
    }
}

/// What a header states: anything that this version doesn't know is not known.
pub(crate) fn read_stated<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<Option<Compression>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Stated {
        Known(Compression),
        Other(serde::de::IgnoredAny),
    }
    Ok(match Stated::deserialize(deserializer)? {
        Stated::Known(compression) if compression.check().is_ok() => Some(compression),
        Stated::Known(_) | Stated::Other(_) => None,
    })
}

/// A compressor that was chosen at run time, by [`Compression`].
#[derive(Clone, Debug)]
pub struct ChosenCompressor<T: Transmittance>(Chosen<T>);

#[derive(Clone, Debug)]
enum Chosen<T: Transmittance> {
    Greedy,
    MinLink(Box<MinLinkCompressor<T>>),
}

impl<T: Transmittance> Compressor<T> for ChosenCompressor<T> {
    #[inline]
    fn compress(
        &mut self,
        tolerance: Tolerance,
        vertices: &[SumVertex<T>],
        emit: &mut impl FnMut(Vertex<T>),
    ) {
        match &mut self.0 {
            Chosen::Greedy => greedy::compress_all(tolerance, vertices, emit),
            Chosen::MinLink(compressor) => compressor.compress(tolerance, vertices, emit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greedy_method_keeps_to_no_side() {
        let greedy = Compression::new(CompressionMethod::Greedy);
        let min_link = Compression::new(CompressionMethod::MinLink);
        assert!(greedy.check().is_ok() && greedy.with_side(Side::Lighter).check().is_err());
        assert!(min_link.with_side(Side::Darker).check().is_ok());
    }
}
