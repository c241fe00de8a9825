//! What C calls: pointers in, status codes out.
//!
//! Every function's contract on pointers stands in the header, and is what the SAFETY reasons
//! rest on: strings end at a zero; an array has as many elements as its count says; handles
//! come from this library and were not released; `out` can be written to. NULL is an error, not
//! a fault, wherever it can be told.

#![expect(unsafe_code, reason = "this module is the border to C")]
#![expect(unreachable_pub, reason = "C reaches them by their names")]

mod bake;
mod cache;
mod deep;
mod guard;
mod map;
mod pointers;
mod shadow;
