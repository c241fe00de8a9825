//! Visibility functions: V(z), the visibility of the light behind everything at
//! depth ≤ z (Lokovic & Veach 2000, §3.1).
//!
//! Invariant, in memory, on disk and after decoding: vertices sorted by z, z
//! finite and ≥ 0, at most two at one z (a step), the first value exactly 1,
//! values in \[0, 1\] and non-increasing in every channel. V is 1 before the
//! first vertex, linear between vertices, right-continuous at steps, and the
//! last value holds to infinity. No vertices: 1 everywhere. Constructors
//! check this; nothing else has to.

use std::marker::PhantomData;

use super::vertex::Vertex;
use crate::error::{Error, Result};
use crate::transmittance::Transmittance;

/// A borrowed visibility function.
///
/// `values` holds one column a channel, each as long as `z`; a coloured
/// function whose channels are all the same holds one column only (§5.2).
#[derive(Debug)]
pub struct VisibilityView<'a, T> {
    z: &'a [f32],
    values: &'a [f32],
    channels: PhantomData<T>,
}

impl<T> Clone for VisibilityView<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for VisibilityView<'_, T> {}

impl<'a, T: Transmittance> VisibilityView<'a, T> {
    /// The function with these columns.
    ///
    /// # Errors
    ///
    /// [`Error::Visibility`] if the columns' lengths don't fit or the
    /// function breaks the invariant of this module. O(n).
    pub fn new(z: &'a [f32], values: &'a [f32]) -> Result<Self> {
        let view = Self::unchecked(z, values);
        view.check()?;
        Ok(view)
    }

    /// The function that is 1 everywhere.
    #[must_use]
    pub const fn clear() -> Self {
        Self::unchecked(&[], &[])
    }

    /// The function with columns that were checked before.
    pub(crate) const fn unchecked(z: &'a [f32], values: &'a [f32]) -> Self {
        Self { z, values, channels: PhantomData }
    }

    /// Checks the columns against the invariant of this module.
    fn check(self) -> Result<()> {
        let count = self.z.len();
        let refuse = |vertex, reason| Err(Error::Visibility { vertex, reason });
        if self.values.len() != count && self.values.len() != count * T::CHANNELS {
            return refuse(0, "the columns' lengths do not fit");
        }
        // A NaN fails every comparison, so each test is for what must hold.
        for (vertex, &z) in self.z.iter().enumerate() {
            if !(0.0..f32::INFINITY).contains(&z) {
                return refuse(vertex, "z must be finite and at least 0");
            }
            if vertex > 0 && self.z[vertex - 1] > z {
                return refuse(vertex, "z must not decrease");
            }
            if vertex > 1 && self.z[vertex - 2] == z {
                return refuse(vertex, "at most two vertices may share a z");
            }
        }
        for column in self.values.chunks_exact(count.max(1)) {
            if column.first().is_some_and(|&first| first != 1.0) {
                return refuse(0, "the first value must be 1");
            }
            if let Some(rise) =
                column.windows(2).position(|pair| pair[0] < pair[1] || pair[1].is_nan())
            {
                return refuse(rise + 1, "values must not increase");
            }
            if column.last().is_some_and(|&last| last < 0.0) {
                return refuse(count - 1, "values must not be negative");
            }
        }
        Ok(())
    }

    /// Number of vertices.
    #[must_use]
    pub const fn len(self) -> usize {
        self.z.len()
    }

    /// True if the function is 1 everywhere because it has no vertices.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.z.is_empty()
    }

    /// The depths of the vertices, ascending.
    #[must_use]
    pub const fn depths(self) -> &'a [f32] {
        self.z
    }

    /// The stored value columns: one, or one a channel.
    #[must_use]
    pub const fn columns(self) -> &'a [f32] {
        self.values
    }

    /// True if one stored channel stands for all.
    #[must_use]
    pub const fn is_mono(self) -> bool {
        T::CHANNELS == 1 || self.values.len() == self.z.len()
    }

    /// The value of vertex `index`.
    ///
    /// # Panics
    ///
    /// If `index` is not below [`Self::len`].
    #[must_use]
    pub fn value(self, index: usize) -> T {
        if self.is_mono() {
            T::splat(self.values[index])
        } else {
            T::from_channels(|channel| self.values[channel * self.z.len() + index])
        }
    }

    /// Vertex `index`.
    ///
    /// # Panics
    ///
    /// If `index` is not below [`Self::len`].
    #[must_use]
    pub fn vertex(self, index: usize) -> Vertex<T> {
        Vertex::new(self.z[index], self.value(index))
    }

    /// All vertices, front to back.
    pub fn vertices(self) -> impl ExactSizeIterator<Item = Vertex<T>> + use<'a, T> {
        (0..self.len()).map(move |index| self.vertex(index))
    }

    /// V(∞): the visibility behind everything.
    #[must_use]
    pub fn last(self) -> T {
        self.len().checked_sub(1).map_or(T::CLEAR, |last| self.value(last))
    }

    /// V(z): the visibility behind everything at depth ≤ z. 1 for NaN. O(log n).
    #[must_use]
    #[inline(always)]
    pub fn at(self, z: f32) -> T {
        self.interpolate(self.z.partition_point(|&vertex| vertex <= z), z)
    }

    /// The limit of V from the light's side: the visibility just in front of depth
    /// z. 1 for NaN. O(log n).
    #[must_use]
    pub fn before(self, z: f32) -> T {
        let next = self.z.partition_point(|&vertex| vertex < z);
        match self.z.get(next) {
            // Interpolation would round a value near 0 away.
            Some(&vertex) if vertex == z => self.value(next),
            _ => self.interpolate(next, z),
        }
    }

    /// The value at `z`, between vertices `next - 1` and `next`.
    #[inline(always)]
    fn interpolate(self, next: usize, z: f32) -> T {
        match self.len().checked_sub(1) {
            None => T::CLEAR,
            // Before the first vertex, whose value is 1, and past the last it
            // is that one twice.
            Some(last) => self.between([next.saturating_sub(1), next.min(last)], z),
        }
    }

    /// The value at `z`, between these vertices or at the one that both are.
    #[inline(always)]
    pub(crate) fn between(self, [near, far]: [usize; 2], z: f32) -> T {
        let share = share(z, self.z[near], self.z[far]);
        interpolate(self.value(near), self.value(far), share)
    }

    /// A copy that owns its columns.
    #[must_use]
    pub fn to_function(self) -> VisibilityFunction<T> {
        VisibilityFunction {
            z: self.z.to_vec(),
            values: self.values.to_vec(),
            channels: PhantomData,
        }
    }
}

/// The fraction of the way from `z0` to `z1` at `z`, in \[0, 1\]. Of a depth that
/// is both, anything finite.
#[inline(always)]
pub(crate) fn share(z: f32, z0: f32, z1: f32) -> f64 {
    let (z0, z1) = (f64::from(z0), f64::from(z1));
    // Without a branch, which could not be foreseen. A NaN becomes 0.
    let share = ((f64::from(z) - z0) / (z1 - z0)).max(0.0);
    share.min(1.0)
}

/// The value between `near` and `far`.
#[inline(always)]
pub(crate) fn interpolate<T: Transmittance>(near: T, far: T, share: f64) -> T {
    T::from_channels(|channel| {
        let (v0, v1) = (f64::from(near.channel(channel)), f64::from(far.channel(channel)));
        (v0 + (v1 - v0) * share) as f32
    })
}

/// A visibility function that owns its vertices.
///
/// ```
/// use dsm_core::{Vertex, VisibilityFunction};
///
/// // Clear up to z = 2, then a linear fall to one half at z = 4.
/// let function = VisibilityFunction::new([Vertex::new(2.0, 1.0), Vertex::new(4.0, 0.5)])?;
/// assert_eq!(function.view().at(3.0), 0.75);
/// assert_eq!(function.view().at(9.0), 0.5);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct VisibilityFunction<T> {
    z: Vec<f32>,
    values: Vec<f32>,
    channels: PhantomData<T>,
}

impl<T: Transmittance> VisibilityFunction<T> {
    /// The function with these vertices.
    ///
    /// # Errors
    ///
    /// [`Error::Visibility`] if they break the invariant of this module.
    pub fn new(vertices: impl IntoIterator<Item = Vertex<T>>) -> Result<Self> {
        let vertices: Vec<_> = vertices.into_iter().collect();
        let function = Self::unchecked(&vertices);
        function.view().check()?;
        Ok(function)
    }

    /// The function with vertices whose maker keeps the invariant.
    pub(crate) fn unchecked(vertices: &[Vertex<T>]) -> Self {
        let mut function = Self::clear();
        append_columns(vertices, &mut function.z, &mut function.values);
        function
    }

    /// The function that is 1 everywhere.
    #[must_use]
    pub const fn clear() -> Self {
        Self { z: Vec::new(), values: Vec::new(), channels: PhantomData }
    }

    /// Borrows the function.
    #[must_use]
    pub fn view(&self) -> VisibilityView<'_, T> {
        VisibilityView::unchecked(&self.z, &self.values)
    }
}

/// Appends the columns of `vertices`, one channel where one stands for all.
pub(crate) fn append_columns<T: Transmittance>(
    vertices: &[Vertex<T>],
    z: &mut Vec<f32>,
    values: &mut Vec<f32>,
) {
    z.extend(vertices.iter().map(|vertex| vertex.z));
    let mono = vertices.iter().all(|vertex| vertex.value.is_mono());
    for channel in 0..if mono { 1 } else { T::CHANNELS } {
        values.extend(vertices.iter().map(|vertex| vertex.value.channel(channel)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmittance::Rgb;

    fn step_then_ramp() -> VisibilityFunction<f32> {
        let vertices = [(1.0, 1.0), (1.0, 0.8), (2.0, 0.8), (4.0, 0.4), (4.0, 0.1)];
        VisibilityFunction::new(vertices.map(|(z, value)| Vertex::new(z, value))).unwrap()
    }

    #[test]
    fn is_right_continuous() {
        let function = step_then_ramp();
        let view = function.view();
        for (z, before, at) in [
            (0.5, 1.0, 1.0),
            (1.0, 1.0, 0.8),
            (1.5, 0.8, 0.8),
            (3.0, 0.6, 0.6),
            (4.0, 0.4, 0.1),
            (f32::INFINITY, 0.1, 0.1),
            (f32::NAN, 1.0, 1.0),
            (f32::NEG_INFINITY, 1.0, 1.0),
        ] {
            assert_eq!((view.before(z), view.at(z)), (before, at), "at {z}");
        }
        assert_eq!(view.last(), 0.1);
    }

    #[test]
    fn the_near_side_of_a_step_is_exact() {
        let vertices = [(1.0, 1.0), (3.0, 1e-30), (3.0, 0.0)];
        let function =
            VisibilityFunction::new(vertices.map(|(z, value)| Vertex::new(z, value))).unwrap();
        assert_eq!(function.view().before(3.0), 1e-30);
    }

    #[test]
    fn empty_is_clear() {
        let function = VisibilityFunction::<Rgb>::clear();
        assert_eq!(function.view().at(3.0), Rgb::CLEAR);
        assert_eq!(function.view().last(), Rgb::CLEAR);
    }

    #[test]
    fn breaks_of_the_invariant_are_refused() {
        for vertices in [
            vec![(1.0, 0.9)],
            vec![(-1.0, 1.0)],
            vec![(f32::INFINITY, 1.0)],
            vec![(f32::NAN, 1.0)],
            vec![(1.0, f32::NAN)],
            vec![(2.0, 1.0), (1.0, 0.5)],
            vec![(1.0, 1.0), (1.0, 0.5), (1.0, 0.2)],
            vec![(1.0, 1.0), (2.0, 0.5), (3.0, 0.6)],
            vec![(1.0, 1.0), (2.0, f32::NAN)],
            vec![(1.0, 1.0), (2.0, -0.1)],
        ] {
            let built = VisibilityFunction::new(vertices.iter().map(|&(z, v)| Vertex::new(z, v)));
            assert!(matches!(built, Err(Error::Visibility { .. })), "{vertices:?}");
        }
    }

    #[test]
    fn equal_channels_are_stored_once() {
        let grey = [Vertex::new(1.0, Rgb::CLEAR), Vertex::new(2.0, Rgb::splat(0.5))];
        let mono = VisibilityFunction::new(grey).unwrap();
        assert!(mono.view().is_mono());
        assert_eq!(mono.view().columns().len(), 2);
        let coloured = [grey[0], Vertex::new(2.0, Rgb::new(0.5, 0.25, 0.0))];
        let colour = VisibilityFunction::new(coloured).unwrap();
        assert!(!colour.view().is_mono());
        assert_eq!(colour.view().vertices().collect::<Vec<_>>(), coloured);
        assert_eq!(mono.view().at(1.5), Rgb::splat(0.75));
    }
}
