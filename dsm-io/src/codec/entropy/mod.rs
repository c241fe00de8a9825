//! Numbers of a few kinds as few bits: the tokens of numbers by how frequent they are
//! among numbers of their kind, in an asymmetric numeral system (Duda 2013; Giesen
//! 2014), and what a token leaves open as it is.
//!
//! Of a payload the bits come first: the frequencies of every kind, then the open bits
//! of all numbers. The words of the numeral system are read from the payload's end
//! backwards; where both meet the payload ends.

mod bits;
mod decoder;
mod encoder;
mod frequencies;
mod token;

pub(super) use decoder::Decoder;
pub(super) use encoder::Encoder;
