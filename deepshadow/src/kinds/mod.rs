//! The kinds of map, a file each: how each is baked and asked.

mod deep;
mod fragments;
mod kind;
mod layered;
mod layers;
mod mtsm;

pub use kind::Kind;
