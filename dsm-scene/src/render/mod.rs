//! Pictures of a scene under one light, with any kind of shadow.

mod image;
mod numbers;
mod png;
mod renderer;
mod shading;
mod sight;

pub use image::{Image, ImageDifference};
pub use png::srgb_code;
pub use renderer::{RenderSettings, Renderer};
