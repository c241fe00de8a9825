//! Opacity of glTF materials.

use std::path::Path;

use glam::{Affine2, Vec2};
use gltf::json::texture::{MagFilter, WrappingMode};
use gltf::material::AlphaMode as GltfAlphaMode;
use gltf::{Document, Material};

use super::at_place;
use super::buffers::{Buffers, load_uri};
use crate::alpha::{Alpha, AlphaMode, AlphaTexture, Wrap};
use crate::error::{Error, Place, Result};
use crate::load::image::{Channel, decode};

/// The images of a file's materials.
pub(super) struct Images<'a> {
    pub(super) document: &'a Document,
    pub(super) buffers: &'a Buffers,
    pub(super) folder: &'a Path,
}

impl Images<'_> {
    /// The opacity that a material's base colour stands for. Its image is read
    /// only if it matters.
    pub(super) fn alpha(&self, material: &Material<'_>) -> Result<Alpha> {
        let mode = match material.alpha_mode() {
            GltfAlphaMode::Opaque => return Ok(Alpha::default()),
            GltfAlphaMode::Mask => AlphaMode::Mask(material.alpha_cutoff().unwrap_or(0.5)),
            GltfAlphaMode::Blend => AlphaMode::Blend,
        };
        let colour = material.pbr_metallic_roughness();
        let factor = colour.base_color_factor()[3];
        let texture = match colour.base_color_texture() {
            None => None,
            Some(info) => {
                let index = info.texture().source().index();
                let texture = self.image(index)?;
                texture.map(|texture| sampled(texture, &info))
            }
        };
        Ok(Alpha { mode, factor, texture })
    }

    fn image(&self, index: usize) -> Result<Option<AlphaTexture>> {
        let place = || Place::Named(format!("image {index}"));
        let image = self.document.as_json().images.get(index);
        let uri = image.and_then(|image| image.uri.as_deref());
        let view = image.and_then(|image| image.buffer_view);
        match (uri, view.and_then(|view| self.document.views().nth(view.value()))) {
            (_, Some(view)) => {
                let bytes = self
                    .buffers
                    .view(&view)
                    .map_err(|error| at_place(error, &place().to_string()))?;
                decode(bytes, Channel::Alpha)
            }
            (Some(uri), None) => decode(&load_uri(uri, self.folder)?, Channel::Alpha),
            (None, None) => Err(Error::malformed(Place::Whole, "missing image")),
        }
        .map_err(|error| at_place(error, &place().to_string()))
    }
}

/// The set of texture coordinates of the base colour.
pub(super) fn uv_set(material: &Material<'_>) -> u32 {
    let colour = material.pbr_metallic_roughness();
    colour.base_color_texture().map_or(0, |info| {
        let moved = info.texture_transform().and_then(|transform| transform.tex_coord());
        moved.unwrap_or_else(|| info.tex_coord())
    })
}

fn sampled(mut texture: AlphaTexture, info: &gltf::texture::Info<'_>) -> AlphaTexture {
    let sampler = info.texture().sampler();
    texture.wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|wrap| match wrap {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    });
    texture.nearest = sampler.mag_filter() == Some(MagFilter::Nearest);
    if let Some(transform) = info.texture_transform() {
        let scale = Vec2::from(transform.scale());
        let (sin, cos) = libm::sincosf(transform.rotation());
        // Counterclockwise where v goes down.
        let rotation = glam::Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        let matrix = rotation * glam::Mat2::from_diagonal(scale);
        texture.uv_transform =
            Affine2::from_mat2_translation(matrix, Vec2::from(transform.offset()));
    }
    texture
}
