//! What the steps of a plan take.

use serde::{Deserialize, Serialize};

/// Memory and time of one task of a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cost {
    /// Resident memory at its peak, in bytes.
    pub(crate) memory: u64,
    /// Seconds.
    pub(crate) seconds: u64,
}

/// Those of all steps, as a trial found them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Costs {
    pub(crate) bake: Cost,
    pub(crate) merge: Cost,
    /// None of maps without smaller levels.
    pub(crate) mip: Option<Cost>,
    pub(crate) verify: Cost,
}

impl Costs {
    /// That of a step.
    pub(crate) fn of(&self, step: super::job::Step) -> Option<Cost> {
        use super::job::Step;
        match step {
            Step::Bake => Some(self.bake),
            Step::Merge => Some(self.merge),
            Step::Mip => self.mip,
            Step::Verify => Some(self.verify),
        }
    }
}

/// A measured number with two digits that count, rounded up: what is measured twice is alike.
pub(crate) fn round_up(number: f64) -> u64 {
    let unit = 10_f64.powf((number.max(1.0).log10().floor() - 1.0).max(0.0));
    ((number / unit).ceil() * unit) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_count() {
        for (number, expected) in [(0.0, 0), (0.2, 1), (9.5, 10), (101.0, 110), (98_765.0, 99_000)]
        {
            assert_eq!(round_up(number), expected, "{number}");
        }
    }
}
