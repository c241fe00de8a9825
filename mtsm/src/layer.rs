//! A layer of a multilayer transparent shadow map, and a pixel's run of them.

use dsm_core::Transmittance;
use dsm_core::detail::VisibilityView;

/// A layer: (zᵢ, vᵢ, countᵢ) of Xie, Tabellion & Pearce 2007, §5.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer<T> {
    /// Depth along the view axis, in scene units, finite and ≥ 0.
    pub depth: f32,
    /// The fraction of light left behind it, within its run.
    pub visibility: T,
    /// Number of samples behind the layer before it, up to this one.
    pub count: u32,
}

/// A run of a pixel: a visibility function that starts at 1, and the counts of
/// its layers. All runs of a pixel but the last end at exactly 0.
///
/// The first layer is where the function starts to fall: its visibility is 1
/// and its count 0. Two layers at one depth are a step, whose samples the second
/// one counts.
#[derive(Debug)]
pub struct LayerRun<'a, T> {
    function: VisibilityView<'a, T>,
    counts: &'a [u32],
}

impl<T> Clone for LayerRun<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for LayerRun<'_, T> {}

impl<'a, T: Transmittance> LayerRun<'a, T> {
    /// A function and as many counts.
    pub(crate) const fn new(function: VisibilityView<'a, T>, counts: &'a [u32]) -> Self {
        Self { function, counts }
    }

    /// The fraction of light left at every depth behind the run before.
    #[must_use]
    pub const fn function(self) -> VisibilityView<'a, T> {
        self.function
    }

    /// The counts of the layers.
    #[must_use]
    pub const fn counts(self) -> &'a [u32] {
        self.counts
    }

    /// Number of layers.
    #[must_use]
    pub const fn len(self) -> usize {
        self.counts.len()
    }

    /// True if there are no layers.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.counts.is_empty()
    }

    /// Layer number `index`, front to back.
    ///
    /// # Panics
    ///
    /// If `index` is not below [`Self::len`].
    #[must_use]
    pub fn layer(self, index: usize) -> Layer<T> {
        let vertex = self.function.vertex(index);
        Layer { depth: vertex.z, visibility: vertex.value, count: self.counts[index] }
    }

    /// The layers, front to back.
    pub fn layers(self) -> impl ExactSizeIterator<Item = Layer<T>> + use<'a, T> {
        (0..self.len()).map(move |index| self.layer(index))
    }

    /// True if no light gets past the run.
    #[must_use]
    pub fn is_opaque(self) -> bool {
        self.function.last() == T::BLOCKED
    }
}
