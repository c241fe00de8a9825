//! Counts of the contents of a map's tiles.

use serde::ser::{Serialize, SerializeMap, Serializer};

/// Named numbers that sum up a map, in the order in which they were first named.
///
/// As JSON it is one object with the names for keys.
///
/// ```
/// use dsm_io::MapSummary;
///
/// let mut summary = MapSummary::default();
/// for layers in [3, 0, 5] {
///     summary.add("layers", layers);
///     summary.max("max_layers_per_pixel", layers);
/// }
/// assert_eq!(summary.count("layers"), Some(8));
/// assert_eq!(summary.count("max_layers_per_pixel"), Some(5));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapSummary {
    entries: Vec<(&'static str, SummaryValue)>,
}

/// A number of a [`MapSummary`], or a list of them.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SummaryValue {
    /// A number of things.
    Count(u64),
    /// Numbers of things in each of several places, such as levels.
    Counts(Vec<u64>),
}

impl MapSummary {
    fn update(&mut self, name: &'static str, next: impl FnOnce(u64) -> u64) {
        match self.entries.iter_mut().find(|(known, _)| *known == name) {
            Some((_, value)) => {
                let before = if let SummaryValue::Count(count) = value { *count } else { 0 };
                *value = SummaryValue::Count(next(before));
            }
            None => self.entries.push((name, SummaryValue::Count(next(0)))),
        }
    }

    /// Adds to the count of this name, which begins at 0.
    pub fn add(&mut self, name: &'static str, count: u64) {
        self.update(name, |before| before.saturating_add(count));
    }

    /// Raises the count of this name to `count`, if it is less.
    pub fn max(&mut self, name: &'static str, count: u64) {
        self.update(name, |before| before.max(count));
    }

    /// Adds the lengths of pixels' lists to the count `sum`, raises `most` to the
    /// longest, and answers how many are empty.
    ///
    /// ```
    /// use dsm_io::MapSummary;
    ///
    /// let mut summary = MapSummary::default();
    /// assert_eq!(summary.add_lists("layers", "max_layers", [3, 0, 5].into_iter()), 1);
    /// assert_eq!((summary.count("layers"), summary.count("max_layers")), (Some(8), Some(5)));
    /// ```
    pub fn add_lists(
        &mut self,
        sum: &'static str,
        most: &'static str,
        lengths: impl Iterator<Item = u64>,
    ) -> u64 {
        let (mut total, mut longest, mut empty) = (0_u64, 0, 0);
        for length in lengths {
            total = total.saturating_add(length);
            longest = longest.max(length);
            empty += u64::from(length == 0);
        }
        self.add(sum, total);
        self.max(most, longest);
        empty
    }

    /// Sets the list of this name.
    pub fn set_counts(&mut self, name: &'static str, counts: Vec<u64>) {
        self.entries.retain(|(known, _)| *known != name);
        self.entries.push((name, SummaryValue::Counts(counts)));
    }

    /// The names and their numbers, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (&'static str, &SummaryValue)> {
        self.entries.iter().map(|(name, value)| (*name, value))
    }

    /// The count of this name, if there is one.
    #[must_use]
    pub fn count(&self, name: &str) -> Option<u64> {
        self.entries.iter().find_map(|(known, value)| match value {
            SummaryValue::Count(count) if *known == name => Some(*count),
            _ => None,
        })
    }
}

impl Serialize for MapSummary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.entries.len()))?;
        for (name, value) in &self.entries {
            match value {
                SummaryValue::Count(count) => map.serialize_entry(name, count),
                SummaryValue::Counts(counts) => map.serialize_entry(name, counts),
            }?;
        }
        map.end()
    }
}
