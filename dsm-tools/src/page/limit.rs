//! How large a page may be.

use std::fmt;
use std::str::FromStr;

/// The most bytes of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PageLimit(pub(crate) u64);

impl PageLimit {
    /// No page is smaller: what draws it takes so much.
    const LEAST: u64 = 200_000;
    /// Browsers hold no longer texts.
    const MOST: u64 = 500_000_000;
    pub(crate) const DEFAULT: Self = Self(20_000_000);
}

impl fmt::Display for PageLimit {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}MB", self.0 as f64 / 1e6)
    }
}

/// Bytes, or a number of `kB`, `MB` (10⁶ bytes).
impl FromStr for PageLimit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let lower = text.trim().to_ascii_lowercase();
        let units = [("mb", 1e6), ("m", 1e6), ("kb", 1e3), ("k", 1e3)];
        let found = units.iter().find_map(|&(unit, size)| Some((lower.strip_suffix(unit)?, size)));
        let (number, size) = found.unwrap_or((&lower, 1.0));
        let bytes =
            number.trim().parse::<f64>().map_err(|_| "no size, such as 20MB".to_owned())? * size;
        if !(Self::LEAST as f64..=Self::MOST as f64).contains(&bytes) {
            return Err("a page has 200 kB to 500 MB".to_owned());
        }
        Ok(Self(bytes as u64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        let read = |text: &str| text.parse::<PageLimit>().ok().map(|limit| limit.0);
        assert_eq!(read("20MB"), Some(20_000_000));
        assert_eq!(read("1.5 mb"), Some(1_500_000));
        assert_eq!(read("300k"), Some(300_000));
        assert_eq!(read("250000"), Some(250_000));
        for wrong in ["", "MB", "10", "-20MB", "NaN", "inf", "1e9MB"] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
        assert_eq!(PageLimit::DEFAULT.to_string(), "20MB");
    }
}
