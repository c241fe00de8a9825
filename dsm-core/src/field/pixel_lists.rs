//! Ragged per-pixel storage: every pixel's visibility function, in columns.
//!
//! All depths stand in one column and all values in another, pixel after
//! pixel in row-major order; `starts` says where each pixel begins (the
//! per-pixel table of Lokovic & Veach 2000, §5.4). A coloured pixel holds
//! three value columns, or one if its channels are all the same (§5.2).

use std::marker::PhantomData;

use fearless_simd::Simd;

use crate::error::{Error, Result};
use crate::transmittance::Transmittance;
use crate::visibility::function::{VisibilityView, append_columns, interpolate, share};
use crate::visibility::search::Window;
use crate::visibility::vertex::Vertex;

/// Borrowed per-pixel functions: a map in memory or a tile in a file.
#[derive(Debug)]
pub struct PixelListsView<'a, T> {
    width: u32,
    height: u32,
    starts: &'a [u32],
    value_starts: &'a [u32],
    z: &'a [f32],
    values: &'a [f32],
    channels: PhantomData<T>,
}

impl<T> Clone for PixelListsView<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for PixelListsView<'_, T> {}

impl<'a, T: Transmittance> PixelListsView<'a, T> {
    /// The functions in these columns. `starts` has one entry a pixel and one
    /// for the end; `value_starts` the same for coloured maps, and is empty
    /// for mono ones.
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] naming the first pixel whose columns don't fit
    /// together or whose function breaks the invariant of
    /// [`VisibilityView`]. O(vertices).
    pub fn new(
        (width, height): (u32, u32),
        starts: &'a [u32],
        value_starts: &'a [u32],
        z: &'a [f32],
        values: &'a [f32],
    ) -> Result<Self> {
        let lists = Self { width, height, starts, value_starts, z, values, channels: PhantomData };
        lists.check()?;
        Ok(lists)
    }

    fn check(self) -> Result<()> {
        let refuse = |pixel, reason| Err(Error::Pixel { pixel, reason });
        let pixels = self.pixel_count();
        let covers = |starts: &[u32], column: &[f32]| {
            starts.len() == pixels + 1
                && starts[0] == 0
                && starts.is_sorted()
                && starts[pixels] as usize == column.len()
        };
        if !covers(self.starts, self.z) {
            return refuse(pixels, "the pixel table does not cover the vertices");
        }
        if T::CHANNELS == 1 {
            if !self.value_starts.is_empty() || self.values.len() != self.z.len() {
                return refuse(pixels, "a mono map holds one value a vertex");
            }
        } else if !covers(self.value_starts, self.values) {
            return refuse(pixels, "the pixel table does not cover the values");
        }
        for pixel in 0..pixels {
            let function = self.function(pixel);
            if let Err(Error::Visibility { reason, .. }) =
                VisibilityView::<T>::new(function.depths(), function.columns())
            {
                return refuse(pixel, reason);
            }
        }
        Ok(())
    }

    /// Width in pixels.
    #[must_use]
    pub const fn width(self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub const fn height(self) -> u32 {
        self.height
    }

    /// Number of pixels.
    #[must_use]
    pub const fn pixel_count(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Number of vertices in all pixels.
    #[must_use]
    pub const fn vertex_count(self) -> usize {
        self.z.len()
    }

    /// The function of the pixel with row-major index `pixel`. O(1).
    ///
    /// # Panics
    ///
    /// If `pixel` is not below [`Self::pixel_count`].
    #[must_use]
    #[inline(always)]
    pub fn function(self, pixel: usize) -> VisibilityView<'a, T> {
        let range = self.starts[pixel] as usize..self.starts[pixel + 1] as usize;
        let values = if T::CHANNELS == 1 {
            range.clone()
        } else {
            self.value_starts[pixel] as usize..self.value_starts[pixel + 1] as usize
        };
        VisibilityView::unchecked(&self.z[range], &self.values[values])
    }

    /// V(`z`) of the pixel with row-major index `pixel`: [`VisibilityView::at`]
    /// with vectors. O(log n).
    ///
    /// # Panics
    ///
    /// If `pixel` is not below [`Self::pixel_count`].
    #[inline(always)]
    pub(crate) fn evaluate<S: Simd>(self, simd: S, pixel: usize, z: f32) -> T {
        let vertices = self.starts[pixel] as usize..self.starts[pixel + 1] as usize;
        if vertices.is_empty() {
            return T::CLEAR;
        }
        let begin = vertices.start;
        let Some(window) = Window::around(self.z, vertices, z) else {
            return self.function(pixel).at(z);
        };
        let Some(depths) = window.of(self.z) else {
            return self.function(pixel).at(z);
        };
        if T::CHANNELS == 1
            && let Some(&values) = window.of(self.values)
        {
            // A copy: the values come from memory while the depths are compared,
            // and not after.
            let [near, far] = window.bracket(simd, depths, z);
            let share = share(z, depths[near], depths[far]);
            interpolate(T::splat(values[near]), T::splat(values[far]), share)
        } else {
            let bracket = window.bracket(simd, depths, z);
            let ahead = window.start() as isize - begin as isize;
            self.function(pixel).between(bracket.map(|lane| lane.wrapping_add_signed(ahead)), z)
        }
    }

    /// The function of the pixel in column `x` and row `y`.
    ///
    /// # Panics
    ///
    /// If (`x`, `y`) lies outside the map.
    #[must_use]
    #[inline(always)]
    pub fn pixel(self, x: u32, y: u32) -> VisibilityView<'a, T> {
        assert!(x < self.width && y < self.height, "pixel ({x}, {y}) is outside the map");
        self.function(y as usize * self.width as usize + x as usize)
    }

    /// All functions, row by row.
    pub fn functions(self) -> impl ExactSizeIterator<Item = VisibilityView<'a, T>> + use<'a, T> {
        (0..self.pixel_count()).map(move |pixel| self.function(pixel))
    }

    /// A copy that owns its columns. O(vertices).
    #[must_use]
    pub fn to_lists(self) -> PixelLists<T> {
        PixelLists {
            width: self.width,
            height: self.height,
            starts: self.starts.to_vec(),
            value_starts: self.value_starts.to_vec(),
            z: self.z.to_vec(),
            values: self.values.to_vec(),
            channels: PhantomData,
        }
    }

    /// First vertex of each pixel, and the end: one entry more than there are
    /// pixels.
    #[must_use]
    pub const fn starts(self) -> &'a [u32] {
        self.starts
    }

    /// First value of each pixel, and the end; empty for mono maps.
    #[must_use]
    pub const fn value_starts(self) -> &'a [u32] {
        self.value_starts
    }

    /// The depths of all vertices.
    #[must_use]
    pub const fn depths(self) -> &'a [f32] {
        self.z
    }

    /// The values of all vertices.
    #[must_use]
    pub const fn values(self) -> &'a [f32] {
        self.values
    }
}

/// Per-pixel functions that own their columns.
///
/// ```
/// use dsm_core::detail::PixelLists;
///
/// // One pixel that falls from 1 to 0.25 at depth 2, and one that is clear.
/// let pixels = PixelLists::<f32>::new((2, 1), vec![0, 2, 2], vec![], vec![2.0; 2], vec![1.0, 0.25])?;
/// assert_eq!(pixels.view().pixel(0, 0).at(3.0), 0.25);
/// assert_eq!(pixels.view().pixel(1, 0).at(3.0), 1.0);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PixelLists<T> {
    width: u32,
    height: u32,
    starts: Vec<u32>,
    value_starts: Vec<u32>,
    z: Vec<f32>,
    values: Vec<f32>,
    channels: PhantomData<T>,
}

impl<T: Transmittance> PixelLists<T> {
    /// The functions in these columns; see [`PixelListsView::new`].
    ///
    /// # Errors
    ///
    /// As [`PixelListsView::new`].
    pub fn new(
        (width, height): (u32, u32),
        starts: Vec<u32>,
        value_starts: Vec<u32>,
        z: Vec<f32>,
        values: Vec<f32>,
    ) -> Result<Self> {
        let lists = Self { width, height, starts, value_starts, z, values, channels: PhantomData };
        lists.view().check()?;
        Ok(lists)
    }

    /// `width` × `height` pixels that are 1 everywhere. O(pixels) memory.
    #[must_use]
    pub fn clear(width: u32, height: u32) -> Self {
        let starts = vec![0; width as usize * height as usize + 1];
        let value_starts = if T::CHANNELS == 1 { Vec::new() } else { starts.clone() };
        let (z, values) = (Vec::new(), Vec::new());
        Self { width, height, starts, value_starts, z, values, channels: PhantomData }
    }

    /// The columns, for callers that keep them: first vertex of each pixel, first value
    /// (empty for mono maps), depths and values, as [`Self::new`] takes them.
    #[must_use]
    pub fn into_columns(self) -> (Vec<u32>, Vec<u32>, Vec<f32>, Vec<f32>) {
        (self.starts, self.value_starts, self.z, self.values)
    }

    /// Borrows the functions.
    #[must_use]
    #[inline(always)]
    pub fn view(&self) -> PixelListsView<'_, T> {
        PixelListsView {
            width: self.width,
            height: self.height,
            starts: &self.starts,
            value_starts: &self.value_starts,
            z: &self.z,
            values: &self.values,
            channels: PhantomData,
        }
    }
}

/// Builds [`PixelLists`] pixel by pixel, row by row.
///
/// ```
/// use dsm_core::{PixelListsBuilder, Vertex};
///
/// let mut pixels = PixelListsBuilder::new(1, 1);
/// pixels.push(Vertex::new(2.0, 1.0_f32));
/// pixels.push(Vertex::new(2.0, 0.25));
/// pixels.finish_pixel()?;
/// let pixels = pixels.finish()?;
/// assert_eq!(pixels.view().vertex_count(), 2);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Debug)]
pub struct PixelListsBuilder<T> {
    lists: PixelLists<T>,
    pixel: Vec<Vertex<T>>,
}

impl<T: Transmittance> PixelListsBuilder<T> {
    /// A builder for `width` × `height` pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        // The table grows with the pixels that come: a size alone takes no
        // memory.
        let lists = PixelLists { width, height, ..PixelLists::clear(0, 0) };
        Self { lists, pixel: Vec::new() }
    }

    /// Adds a vertex to the current pixel, front to back.
    pub fn push(&mut self, vertex: Vertex<T>) {
        self.pixel.push(vertex);
    }

    /// Ends the current pixel and begins the next.
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] if its vertices break the invariant of
    /// [`VisibilityView`], [`Error::TooLarge`] past 2³² − 1 values. The pixel
    /// is empty then, and the builder can go on.
    pub fn finish_pixel(&mut self) -> Result<()> {
        let PixelLists { starts, value_starts, z, values, .. } = &mut self.lists;
        let (first, first_value) = (z.len(), values.len());
        append_columns(&self.pixel, z, values);
        self.pixel.clear();
        let checked = VisibilityView::<T>::new(&z[first..], &values[first_value..]);
        let refused = match (checked, u32::try_from(values.len())) {
            (Ok(_), Ok(_)) => None,
            (Err(Error::Visibility { reason, .. }), _) => {
                Some(Error::Pixel { pixel: starts.len() - 1, reason })
            }
            (Err(error), _) => Some(error),
            (_, Err(_)) => Some(Error::TooLarge {
                what: "values in one block of pixels",
                count: values.len() as u64,
                limit: u64::from(u32::MAX),
            }),
        };
        if refused.is_some() {
            z.truncate(first);
            values.truncate(first_value);
        }
        // Both fit: a column that grew past u32 was cut off again above.
        starts.push(z.len() as u32);
        if T::CHANNELS > 1 {
            value_starts.push(values.len() as u32);
        }
        refused.map_or(Ok(()), Err)
    }

    /// The pixel that was finished last.
    #[must_use]
    pub fn last_pixel(&self) -> Option<VisibilityView<'_, T>> {
        let PixelLists { starts, value_starts, z, values, .. } = &self.lists;
        let first = *starts.iter().nth_back(1)? as usize;
        let first_value = value_starts.iter().nth_back(1).map_or(first, |&start| start as usize);
        Some(VisibilityView::unchecked(&z[first..], &values[first_value..]))
    }

    /// The pixels that were finished, however many, as a map of one row: for
    /// lists of functions that are no rectangle.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 2³² − 1 pixels.
    pub fn finish_row(mut self) -> Result<PixelLists<T>> {
        let count = self.lists.starts.len() as u64 - 1;
        let limit = u64::from(u32::MAX);
        let too_large = |_| Error::TooLarge { what: "functions in one row", count, limit };
        self.lists.width = u32::try_from(count).map_err(too_large)?;
        self.lists.height = 1;
        Ok(self.lists)
    }

    /// The finished lists.
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] unless exactly width × height pixels were finished.
    pub fn finish(self) -> Result<PixelLists<T>> {
        let (pixels, finished) = (self.lists.view().pixel_count(), self.lists.starts.len() - 1);
        if finished == pixels {
            Ok(self.lists)
        } else {
            Err(Error::Pixel {
                pixel: finished,
                reason: "every pixel must be finished exactly once",
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmittance::Rgb;

    #[test]
    fn pixels_come_back_as_they_went_in() {
        let coloured = [Vertex::new(1.0, Rgb::CLEAR), Vertex::new(1.0, Rgb::new(0.5, 0.4, 0.3))];
        let grey = [Vertex::new(2.0, Rgb::CLEAR), Vertex::new(3.0, Rgb::splat(0.25))];
        let mut builder = PixelListsBuilder::new(3, 1);
        for pixel in [&coloured[..], &[], &grey] {
            pixel.iter().for_each(|&vertex| builder.push(vertex));
            builder.finish_pixel().unwrap();
            assert!(builder.last_pixel().unwrap().vertices().eq(pixel.iter().copied()));
        }
        let lists = builder.finish().unwrap();
        let view = lists.view();
        assert_eq!(view.pixel(0, 0).vertices().collect::<Vec<_>>(), coloured);
        assert!(view.pixel(1, 0).is_empty());
        assert_eq!(view.pixel(2, 0).vertices().collect::<Vec<_>>(), grey);
        assert_eq!(view.values().len(), 6 + 2);
        assert_eq!(view.to_lists(), lists);
        let (starts, value_starts, z, values) = lists.clone().into_columns();
        assert_eq!(PixelLists::new((3, 1), starts, value_starts, z, values).unwrap(), lists);
    }

    #[test]
    fn a_refused_pixel_is_left_empty() {
        let mut builder = PixelListsBuilder::<f32>::new(2, 1);
        builder.push(Vertex::new(1.0, 0.5));
        assert!(matches!(builder.finish_pixel(), Err(Error::Pixel { pixel: 0, .. })));
        builder.push(Vertex::new(1.0, 1.0));
        builder.finish_pixel().unwrap();
        let lists = builder.finish().unwrap();
        assert_eq!(lists.view().starts(), [0, 0, 1]);
    }

    #[test]
    fn columns_that_do_not_fit_are_refused() {
        let lists = |starts: &[u32], z: &[f32], values: &[f32]| {
            PixelLists::<f32>::new((2, 1), starts.to_vec(), vec![], z.to_vec(), values.to_vec())
        };
        assert!(lists(&[0, 1, 2], &[1.0, 2.0], &[1.0, 1.0]).is_ok());
        for (starts, z, values) in [
            (&[0, 1][..], &[1.0, 2.0][..], &[1.0, 1.0][..]),
            (&[1, 1, 2], &[1.0, 2.0], &[1.0, 1.0]),
            (&[0, 2, 1], &[1.0, 2.0], &[1.0, 1.0]),
            (&[0, 1, 3], &[1.0, 2.0], &[1.0, 1.0]),
            (&[0, 1, 2], &[1.0, 2.0], &[1.0]),
            (&[0, 1, 2], &[1.0, 2.0], &[1.0, 0.5]),
        ] {
            assert!(lists(starts, z, values).is_err(), "{starts:?}");
        }
    }

    #[test]
    fn any_number_of_pixels_makes_a_row() {
        for count in [0, 1, 3] {
            let mut builder = PixelListsBuilder::new(0, 0);
            for _ in 0..count {
                builder.push(Vertex::new(1.0, 1.0_f32));
                builder.finish_pixel().unwrap();
            }
            let row = builder.finish_row().unwrap();
            let view = row.view();
            assert_eq!([view.width(), view.height()], [count, 1]);
            assert_eq!(view.functions().len(), count as usize);
        }
    }

    #[test]
    fn a_size_alone_takes_no_memory() {
        assert!(PixelListsBuilder::<Rgb>::new(u32::MAX, u32::MAX).finish().is_err());
    }

    #[test]
    fn an_unfinished_map_is_refused() {
        assert!(PixelListsBuilder::<f32>::new(2, 1).finish().is_err());
    }
}
