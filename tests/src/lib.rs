//! Contracts across the libraries: see the tests of this package, which share
//! what stands here.

pub mod forge;
pub mod fuzz;
pub mod golden;

/// The README's example compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
