//! The stored numbers of one pixel, for display.

use dsm_core::Transmittance;
use serde::ser::{Serialize, Serializer};

/// The numbers that are stored of one pixel, as a table or as several.
///
/// ```
/// use dsm_io::PixelContents;
/// use dsm_io::detail::PixelValue;
///
/// let mut layers = PixelContents::new("layers", &["depth", "light left"]);
/// layers.push([PixelValue::Number(2.0), PixelValue::light(0.5_f32)]);
/// assert_eq!(layers.rows().len(), 1);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PixelContents {
    name: &'static str,
    columns: &'static [&'static str],
    rows: Vec<Vec<PixelValue>>,
    /// Where each list begins; none: there are no several lists.
    starts: Option<Vec<usize>>,
}

/// A number of a pixel, or one a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PixelValue {
    /// A real number, such as a depth.
    Number(f32),
    /// A number of things.
    Count(u32),
    /// A fraction of light in each of three channels.
    Rgb([f32; 3]),
    /// A bit for each of 8 × 8 places of a pixel, row by row from its upper left corner on,
    /// the lowest bit first. As text 16 hexadecimal digits after `0x`.
    Mask(u64),
}

impl PixelValue {
    /// A fraction of light, of one channel or three.
    #[must_use]
    pub fn light<T: Transmittance>(value: T) -> Self {
        if T::CHANNELS == 1 {
            Self::Number(value.channel(0))
        } else {
            Self::Rgb([0, 1, 2].map(|channel| value.channel(channel)))
        }
    }
}

impl PixelContents {
    /// A pixel without rows: `name` is what they are together, `columns` are what
    /// each row has.
    #[must_use]
    pub const fn new(name: &'static str, columns: &'static [&'static str]) -> Self {
        Self { name, columns, rows: Vec::new(), starts: None }
    }

    /// A pixel of several lists of rows, none of which has begun.
    #[must_use]
    pub const fn of_lists(name: &'static str, columns: &'static [&'static str]) -> Self {
        Self { name, columns, rows: Vec::new(), starts: Some(Vec::new()) }
    }

    /// Begins the next list, of a pixel of several.
    pub fn begin_list(&mut self) {
        if let Some(starts) = &mut self.starts {
            starts.push(self.rows.len());
        }
    }

    /// Appends a row: one number a column.
    pub fn push(&mut self, row: impl IntoIterator<Item = PixelValue>) {
        self.rows.push(row.into_iter().collect());
    }

    /// The name of the rows together: `vertices`, `runs`.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The names of the columns.
    #[must_use]
    pub const fn columns(&self) -> &'static [&'static str] {
        self.columns
    }

    /// All rows, front to back.
    #[must_use]
    pub fn rows(&self) -> &[Vec<PixelValue>] {
        &self.rows
    }

    /// True if the rows stand in several lists.
    #[must_use]
    pub const fn has_lists(&self) -> bool {
        self.starts.is_some()
    }

    /// The rows list by list; one list of all rows where there are no several.
    pub fn lists(&self) -> impl Iterator<Item = &[Vec<PixelValue>]> {
        let starts = self.starts.as_deref().unwrap_or(&[0]);
        let ends = starts.iter().skip(1).copied().chain([self.rows.len()]);
        starts.iter().zip(ends).map(|(&start, end)| &self.rows[start..end])
    }
}

impl Serialize for PixelValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => number.serialize(serializer),
            Self::Count(count) => count.serialize(serializer),
            Self::Rgb(values) => values.serialize(serializer),
            Self::Mask(mask) => serializer.collect_str(&format_args!("{mask:#018x}")),
        }
    }
}

/// One array a row, in an array, or in one a list.
impl Serialize for PixelContents {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.has_lists() {
            serializer.collect_seq(self.lists())
        } else {
            self.rows.serialize(serializer)
        }
    }
}
