//! The program `dsm-tools` as scripts see it: what it prints, what it writes
//! and how it exits.

#![cfg(test)]

mod attenuation;
mod bake;
mod cases;
mod coherence;
mod compression;
mod convert;
mod diff;
mod disk;
mod farm;
mod inspect;
mod layers;
mod lookup;
mod maps;
mod merge;
mod mip;
mod mistakes;
mod odd_lights;
mod pages;
mod positions;
mod prefiltered;
mod render;
mod run;
mod soft_cases;
mod soft_shadows;
mod stated;
mod thin_surfaces;
mod usage;
mod verify;
mod version;
mod views;
mod warnings;
mod written;
