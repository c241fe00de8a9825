//! The switch of the far table.

use clap::ValueEnum;
use deepshadow::FarTable;

/// The values of `--far-table`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum FarTableName {
    Auto,
    On,
    Off,
}

impl FarTableName {
    /// The refusal of the switch where no fragments are traced.
    pub(super) const NOT_TRACED: &str = "--far-table is for --method trace";
}

impl From<FarTableName> for FarTable {
    fn from(name: FarTableName) -> Self {
        match name {
            FarTableName::Auto => Self::Auto,
            FarTableName::On => Self::On,
            FarTableName::Off => Self::Off,
        }
    }
}
