//! Contracts across the libraries: see the tests of this package, which share
//! what stands here.

pub mod forge;
pub mod fuzz;
pub mod golden;

/// An error with its causes in one line, as the program prints it.
#[must_use]
pub fn whole_message(error: dsm_io::Error) -> String {
    format!("{:#}", anyhow::Error::from(error))
}

/// The README's example compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
