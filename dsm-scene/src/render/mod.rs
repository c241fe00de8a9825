//! Pictures of a scene under one light, with any kind of shadow.

mod image;
mod numbers;
mod renderer;
mod shading;
mod sight;

pub use image::{Image, ImageDifference};
pub use renderer::{RenderProgress, RenderSettings, Renderer};
