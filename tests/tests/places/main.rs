//! No answer depends on where a scene stands, on how large its unit is, or on threads and
//! tiles: every kind of map, every method, from the bake to the picture.

#![cfg(test)]

mod hits;
mod methods;
mod pictures;
mod scene;
