//! The samples of some pixel rows, in columns.

use std::ops::Range;

use crate::channel::AlphaChannels;
use crate::error::{Error, Result};
use crate::sample::DeepSample;

/// Opacities of all samples of a [`DeepRows`].
///
/// ```
/// use deep_exr::detail::Alpha;
/// use deep_exr::{AlphaChannels, DeepRows};
///
/// let rows = DeepRows::new(1, AlphaChannels::Colour, false);
/// assert!(matches!(rows.alpha(), Alpha::Colour([red, _, _]) if red.is_empty()));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Alpha {
    /// The file has no alpha: all samples are opaque.
    Opaque,
    /// One opacity a sample.
    Mono(Vec<f32>),
    /// One opacity a sample and colour: red, green, blue.
    Colour([Vec<f32>; 3]),
}

/// A column of the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Column {
    Z,
    ZBack,
    Alpha,
    Red,
    Green,
    Blue,
}

/// Samples of whole pixel rows, a column for each channel.
///
/// Pixels stand row by row, and their samples in the file's order, which need
/// not be by depth. Values are as in the file: they may be NaN, negative, or
/// outside [0, 1].
///
/// ```
/// use deep_exr::{AlphaChannels, DeepRows, DeepSample};
///
/// // A row of two pixels: one with a surface before a volume, one empty.
/// let mut rows = DeepRows::new(2, AlphaChannels::Mono, true);
/// rows.push(DeepSample { z: 1.0, z_back: 1.0, alpha: [0.5; 3] });
/// rows.push(DeepSample { z: 2.0, z_back: 4.0, alpha: [0.9; 3] });
/// rows.finish_pixel()?;
/// rows.finish_pixel()?;
/// assert_eq!((rows.rows(), rows.pixel(0), rows.pixel(1)), (1, 0..2, 2..2));
/// assert_eq!(rows.z_back(), Some(&[1.0, 4.0][..]));
/// # Ok::<(), deep_exr::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DeepRows {
    width: u32,
    offsets: Vec<u32>,
    z: Vec<f32>,
    z_back: Option<Vec<f32>>,
    alpha: Alpha,
}

impl DeepRows {
    /// No pixels yet of an image of this width, with these columns.
    #[must_use]
    pub fn new(width: u32, alpha: AlphaChannels, z_back: bool) -> Self {
        Self {
            width,
            offsets: vec![0],
            z: Vec::new(),
            z_back: z_back.then(Vec::new),
            alpha: match alpha {
                AlphaChannels::None => Alpha::Opaque,
                AlphaChannels::Mono => Alpha::Mono(Vec::new()),
                AlphaChannels::Colour => Alpha::Colour(Default::default()),
            },
        }
    }

    /// Whole rows of an image of this width from columns: the start of each pixel's
    /// samples and the end, front depths, back depths where there are any, and opacities.
    ///
    /// # Errors
    ///
    /// [`Error::Rows`] for offsets that are no whole rows, do not begin at 0, fall, or do
    /// not end with the columns, and for columns of different lengths. O(pixels).
    pub fn from_columns(
        width: u32,
        offsets: Vec<u32>,
        z: Vec<f32>,
        z_back: Option<Vec<f32>>,
        alpha: Alpha,
    ) -> Result<Self> {
        let rows = Self { width, offsets, z, z_back, alpha };
        rows.check().map_err(|reason| Error::Rows { place: "columns".to_owned(), reason })?;
        Ok(rows)
    }

    fn check(&self) -> Result<(), &'static str> {
        let Some((&first, &last)) = self.offsets.first().zip(self.offsets.last()) else {
            return Err("there are no offsets: one more than pixels are needed");
        };
        if first != 0 || !self.offsets.is_sorted() {
            return Err("offsets begin at 0 and do not fall");
        }
        if last as usize != self.z.len() {
            return Err("the last offset is not the number of samples");
        }
        if self.width == 0 || !self.pixel_count().is_multiple_of(self.width as usize) {
            return Err("the pixels are no whole rows");
        }
        let opacities: &[&Vec<f32>] = match &self.alpha {
            Alpha::Opaque => &[],
            Alpha::Mono(column) => &[column],
            Alpha::Colour([red, green, blue]) => &[red, green, blue],
        };
        let mut columns = opacities.iter().copied().chain(&self.z_back);
        if columns.any(|column| column.len() != self.z.len()) {
            return Err("the columns are not of one length");
        }
        Ok(())
    }

    /// The columns, as [`Self::from_columns`] takes them.
    #[must_use]
    pub fn into_columns(self) -> (Vec<u32>, Vec<f32>, Option<Vec<f32>>, Alpha) {
        (self.offsets, self.z, self.z_back, self.alpha)
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of pixel rows.
    #[must_use]
    pub fn rows(&self) -> u32 {
        (self.pixel_count() / self.width.max(1) as usize) as u32
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixel_count(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Number of samples.
    #[must_use]
    pub fn sample_count(&self) -> usize {
        self.z.len()
    }

    /// Start of each pixel's samples in the columns, and the end: one more than
    /// pixels.
    #[must_use]
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// Front depths of all samples.
    #[must_use]
    pub fn z(&self) -> &[f32] {
        &self.z
    }

    /// Back depths of all samples, where the file has them.
    #[must_use]
    pub fn z_back(&self) -> Option<&[f32]> {
        self.z_back.as_deref()
    }

    /// Opacities of all samples.
    #[must_use]
    pub fn alpha(&self) -> &Alpha {
        &self.alpha
    }

    /// The samples of a pixel, as indices into the columns. Pixels count from
    /// 0, row by row: `row * width + column`.
    ///
    /// # Panics
    ///
    /// If there is no such pixel.
    #[must_use]
    pub fn pixel(&self, pixel: usize) -> Range<usize> {
        self.offsets[pixel] as usize..self.offsets[pixel + 1] as usize
    }

    /// A sample by its index in the columns.
    ///
    /// # Panics
    ///
    /// If there is no such sample.
    #[must_use]
    pub fn sample(&self, index: usize) -> DeepSample {
        let z = self.z[index];
        DeepSample {
            z,
            z_back: self.z_back.as_ref().map_or(z, |column| column[index]),
            alpha: match &self.alpha {
                Alpha::Opaque => [1.0; 3],
                Alpha::Mono(column) => [column[index]; 3],
                Alpha::Colour(columns) => [0, 1, 2].map(|colour| columns[colour][index]),
            },
        }
    }

    /// Kind of the samples' opacities.
    #[must_use]
    pub fn alpha_channels(&self) -> AlphaChannels {
        match self.alpha {
            Alpha::Opaque => AlphaChannels::None,
            Alpha::Mono(_) => AlphaChannels::Mono,
            Alpha::Colour(_) => AlphaChannels::Colour,
        }
    }

    /// Takes all pixels out; the columns keep their memory.
    pub fn clear(&mut self) {
        self.offsets.truncate(1);
        self.resize(0);
    }

    /// Adds a sample to the pixel that [`Self::finish_pixel`] will end. A
    /// mono column takes the first opacity.
    pub fn push(&mut self, sample: DeepSample) {
        self.z.push(sample.z);
        if let Some(column) = &mut self.z_back {
            column.push(sample.z_back);
        }
        match &mut self.alpha {
            Alpha::Opaque => {}
            Alpha::Mono(column) => column.push(sample.alpha[0]),
            Alpha::Colour(columns) => {
                columns.iter_mut().zip(sample.alpha).for_each(|(column, own)| column.push(own));
            }
        }
    }

    /// Ends a pixel; the next samples are another's.
    ///
    /// # Errors
    ///
    /// [`Error::LimitExceeded`] for more than 2³² − 1 samples.
    pub fn finish_pixel(&mut self) -> Result<()> {
        let end = u32::try_from(self.z.len());
        self.offsets.push(end.map_err(|_| self.too_many_samples(self.z.len() as u64))?);
        Ok(())
    }

    /// Whether the last row, and its last pixel, are finished.
    pub(crate) fn ends_with_a_row(&self) -> bool {
        let last = self.offsets.last().copied().unwrap_or(0);
        self.pixel_count().is_multiple_of(self.width.max(1) as usize)
            && last as usize == self.sample_count()
    }

    fn too_many_samples(&self, value: u64) -> Error {
        Error::LimitExceeded {
            place: format!("{} pixels", self.pixel_count()),
            what: "number of samples in one answer",
            value,
            limit: u32::MAX.into(),
        }
    }

    /// Gives every column `samples` entries; new opacities are 1.
    fn resize(&mut self, samples: usize) {
        self.z.resize(samples, 0.0);
        if let Some(column) = &mut self.z_back {
            column.resize(samples, 0.0);
        }
        match &mut self.alpha {
            Alpha::Opaque => {}
            Alpha::Mono(column) => column.resize(samples, 1.0),
            Alpha::Colour(columns) => columns.iter_mut().for_each(|c| c.resize(samples, 1.0)),
        }
    }

    /// Bytes of one sample in the columns.
    pub(crate) fn sample_bytes(&self) -> u64 {
        let alphas = match self.alpha {
            Alpha::Opaque => 0,
            Alpha::Mono(_) => 1,
            Alpha::Colour(_) => 3,
        };
        4 * (1 + u64::from(self.z_back.is_some()) + alphas)
    }

    /// Adds pixels with no samples, one entry each, and returns their entries
    /// in the offsets: put each pixel's number of samples there, then call
    /// [`Self::add_counted_samples`].
    pub(crate) fn add_pixels(&mut self, pixels: usize) -> &mut [u32] {
        let first = self.offsets.len();
        self.offsets.resize(first + pixels, 0);
        &mut self.offsets[first..]
    }

    /// Turns the numbers of samples from pixel `first` on into offsets, and
    /// makes room for the samples.
    pub(crate) fn add_counted_samples(&mut self, first: usize) -> Result<()> {
        let mut total = u64::from(self.offsets[first]);
        for offset in &mut self.offsets[first + 1..] {
            total += u64::from(*offset);
            *offset = total as u32;
        }
        if total > u64::from(u32::MAX) {
            return Err(self.too_many_samples(total));
        }
        self.resize(total as usize);
        Ok(())
    }

    /// A column to fill. `None` only for one that these rows do not have.
    pub(crate) fn column_mut(&mut self, column: Column) -> Option<&mut [f32]> {
        match (column, &mut self.alpha) {
            (Column::Z, _) => Some(&mut self.z),
            (Column::ZBack, _) => self.z_back.as_deref_mut(),
            (Column::Alpha, Alpha::Mono(column)) => Some(column),
            (Column::Red, Alpha::Colour([red, ..])) => Some(red),
            (Column::Green, Alpha::Colour([_, green, _])) => Some(green),
            (Column::Blue, Alpha::Colour([.., blue])) => Some(blue),
            _ => None,
        }
    }

    /// Appends some rows with the same columns.
    pub(crate) fn append(&mut self, other: &Self, rows: Range<u32>) -> Result<()> {
        let width = self.width as usize;
        let pixels = rows.start as usize * width..rows.end as usize * width;
        let first = self.pixel_count();
        let counts = other.offsets[pixels.start..=pixels.end].windows(2);
        let added = self.add_pixels(pixels.len());
        for (entry, ends) in added.iter_mut().zip(counts) {
            *entry = ends[1] - ends[0];
        }
        let target = self.sample_count();
        self.add_counted_samples(first)?;
        let samples = other.offsets[pixels.start] as usize..other.offsets[pixels.end] as usize;
        let copy =
            |to: &mut [f32], from: &[f32]| to[target..].copy_from_slice(&from[samples.clone()]);
        copy(&mut self.z, &other.z);
        if let (Some(to), Some(from)) = (&mut self.z_back, &other.z_back) {
            copy(to, from);
        }
        match (&mut self.alpha, &other.alpha) {
            (Alpha::Mono(to), Alpha::Mono(from)) => copy(to, from),
            (Alpha::Colour(to), Alpha::Colour(from)) => {
                to.iter_mut().zip(from).for_each(|(to, from)| copy(to, from));
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(offsets: &[u32], z_back: usize, alpha: usize) -> Result<DeepRows> {
        let (back, alpha) = (Some(vec![2.0; z_back]), Alpha::Mono(vec![0.5; alpha]));
        DeepRows::from_columns(2, offsets.to_vec(), vec![1.0, 3.0], back, alpha)
    }

    #[test]
    fn columns_come_back_as_they_went_in() {
        let made = rows(&[0, 2, 2], 2, 2).unwrap();
        assert_eq!((made.rows(), made.pixel(0), made.pixel(1)), (1, 0..2, 2..2));
        let (offsets, z, z_back, alpha) = made.clone().into_columns();
        assert_eq!(DeepRows::from_columns(2, offsets, z, z_back, alpha).unwrap(), made);
    }

    #[test]
    fn columns_that_do_not_fit_are_refused() {
        for (offsets, z_back, alpha) in [
            (&[][..], 2, 2),
            (&[0, 2], 2, 2),
            (&[1, 2, 2], 2, 2),
            (&[0, 2, 1], 2, 2),
            (&[0, 1, 3], 2, 2),
            (&[0, 2, 2], 1, 2),
            (&[0, 2, 2], 2, 3),
        ] {
            let refused = rows(offsets, z_back, alpha);
            assert!(matches!(refused, Err(Error::Rows { .. })), "{offsets:?} {z_back} {alpha}");
        }
    }
}
