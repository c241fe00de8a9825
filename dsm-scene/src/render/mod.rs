//! Pictures of a scene under one light, with any shadow method.

mod image;
mod interaction;
mod png;
mod renderer;
mod sampler;
mod shading;

pub use image::{Image, ImageDifference};
pub use png::srgb_code;
pub use renderer::{RenderSettings, Renderer};
