//! Contracts across the libraries: see the tests of this package.
