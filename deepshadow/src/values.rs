//! The answers of a query.

use dsm_core::Transmittance;

/// Shadow factors of points, in their order: 1 is lit, 0 is dark. One number a
/// point for mono maps, three for RGB ones.
///
/// ```
/// use deepshadow::Values;
///
/// let values = Values::Mono(vec![1.0, 0.25]);
/// assert_eq!((values.len(), values.channels()), (2, 1));
/// assert_eq!(values.rgb(1), [0.25; 3]);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Values {
    /// Values of a map with one channel.
    Mono(Vec<f32>),
    /// Values of a map with three channels: red, green and blue.
    Rgb(Vec<[f32; 3]>),
}

impl Values {
    /// Room for the answers of a map with this number of channels.
    pub(crate) const fn of(channels: usize) -> Self {
        if channels == 1 { Self::Mono(Vec::new()) } else { Self::Rgb(Vec::new()) }
    }

    /// The number of points.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::Mono(values) => values.len(),
            Self::Rgb(values) => values.len(),
        }
    }

    /// True if there are no points.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Numbers a point: 1 or 3.
    #[must_use]
    pub const fn channels(&self) -> usize {
        match self {
            Self::Mono(_) => 1,
            Self::Rgb(_) => 3,
        }
    }

    /// The three channels of a point; of a mono map all the same.
    ///
    /// # Panics
    ///
    /// If there is no such point.
    #[must_use]
    pub fn rgb(&self, point: usize) -> [f32; 3] {
        match self {
            Self::Mono(values) => [values[point]; 3],
            Self::Rgb(values) => values[point],
        }
    }

    /// Appends values with as many channels.
    pub(crate) fn extend<T: Transmittance>(&mut self, more: &[T]) {
        match self {
            Self::Mono(values) => values.extend(more.iter().map(|value| value.channel(0))),
            Self::Rgb(values) => values.extend(
                more.iter().map(|value| [0, 1, 2].map(|at| value.channel(at.min(T::CHANNELS - 1)))),
            ),
        }
    }

    /// Appends the values of other points.
    pub(crate) fn append(&mut self, more: &Self) {
        match (self, more) {
            (Self::Mono(values), Self::Mono(more)) => values.extend_from_slice(more),
            (Self::Rgb(values), more) => {
                values.extend((0..more.len()).map(|point| more.rgb(point)));
            }
            (Self::Mono(values), Self::Rgb(more)) => values.extend(more.iter().map(|rgb| rgb[0])),
        }
    }
}
