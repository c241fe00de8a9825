//! The kinds of map, a file each: how each is baked and queried.

mod attenuation;
mod deep;
mod fragments;
mod implementation;
mod layered;
mod layers;
mod mtsm;
mod prefiltered;
mod shadow_kind;
mod views;

pub(crate) use implementation::implementation;
