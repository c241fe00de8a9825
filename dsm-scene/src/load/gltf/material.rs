//! Opacity of glTF materials.

use glam::{Affine2, Vec2};

use super::buffers::{Buffers, load_uri, percent_decoded};
use super::json::{Material, Sampler, Texture, TextureInfo};
use super::{at_place, malformed};
use crate::alpha::{Alpha, AlphaMode, AlphaTexture, Wrap};
use crate::error::{Place, Result};
use crate::load::image::Channel;
use crate::load::library::Library;
use crate::load::warnings::Warnings;
use std::path::Path;

/// The materials of a file.
pub(super) struct Materials<'a> {
    pub(super) buffers: &'a Buffers<'a>,
    /// The file that they are in.
    pub(super) path: &'a Path,
    pub(super) library: &'a Library,
}

/// A material's opacity, and the set of texture coordinates of its texture.
pub(super) struct Opacity {
    pub(super) alpha: Alpha,
    pub(super) uv_set: usize,
}

impl Materials<'_> {
    /// The opacity that a material's base colour stands for. Its image is read only if
    /// it matters.
    pub(super) fn opacity(&self, index: Option<usize>, warnings: &mut Warnings) -> Result<Opacity> {
        let opaque = Opacity { alpha: Alpha::default(), uv_set: 0 };
        let Some(index) = index else { return Ok(opaque) };
        let Some(material) = self.buffers.root.materials.get(index) else {
            return Err(malformed(format!("no material {index}")));
        };
        let name = match &material.name {
            Some(name) => format!("material {index} ({name:.60})"),
            None => format!("material {index}"),
        };
        warn_of_transmission(material, &name, warnings);
        let mode = match material.alpha_mode.as_deref() {
            None | Some("OPAQUE") => return Ok(opaque),
            Some("MASK") => AlphaMode::Mask(material.alpha_cutoff.unwrap_or(0.5)),
            Some("BLEND") => AlphaMode::Blend,
            Some(mode) => {
                warnings.add(format!("{name}: alpha mode {mode:.20} is not known: it is opaque"));
                return Ok(opaque);
            }
        };
        let colour = &material.pbr_metallic_roughness;
        let (factor, texture) = match &material.extensions.specular_glossiness {
            Some(colour) => (colour.diffuse_factor, &colour.diffuse_texture),
            None => (colour.base_color_factor, &colour.base_color_texture),
        };
        let factor = factor.map_or(1.0, |[_, _, _, alpha]| alpha);
        let Some(info) = texture else {
            return Ok(Opacity { alpha: Alpha { mode, factor, texture: None }, uv_set: 0 });
        };
        let texture = self
            .texture(info, &name, warnings)
            .map_err(|error| at_place(error, &name))?
            .map(|(texture, sampler)| sampled(texture, info, sampler));
        let transform = info.extensions.transform.as_ref();
        let moved = transform.and_then(|transform| transform.tex_coord);
        let uv_set = moved.unwrap_or(info.tex_coord).0;
        Ok(Opacity { alpha: Alpha { mode, factor, texture }, uv_set })
    }

    /// Refuses `bytes` of the file's mesh that do not fit.
    pub(super) fn check_memory(&self, bytes: u64) -> Result<()> {
        self.library.check_bytes(self.path, bytes)
    }

    /// The alpha of a texture and its sampler; `None` if it is opaque.
    fn texture(
        &self,
        info: &TextureInfo,
        material: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<(AlphaTexture, Option<&Sampler>)>> {
        let root = self.buffers.root;
        let Some(texture) = root.textures.get(info.index.0) else {
            return Err(malformed(format!("no texture {}", info.index.0)));
        };
        let Some(image) = source(texture) else {
            let what = format!("texture {}", info.index.0);
            warnings.add(format!("{material}: {what} has no image: its alpha is taken for 1"));
            return Ok(None);
        };
        let sampler = match texture.sampler {
            None => None,
            Some(index) => Some(
                root.samplers
                    .get(index.0)
                    .ok_or_else(|| malformed(format!("no sampler {}", index.0)))?,
            ),
        };
        Ok(self.image(image)?.map(|texture| (texture, sampler)))
    }

    fn image(&self, index: usize) -> Result<Option<AlphaTexture>> {
        let Some(image_of) = self.buffers.root.images.get(index) else {
            return Err(malformed(format!("no image {index}")));
        };
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let inside = (self.path.to_owned(), Some(index));
        let image = |place, read: &dyn Fn() -> Result<Vec<u8>>| {
            self.library.image(place, Channel::Alpha, read)
        };
        match (image_of.buffer_view, &image_of.uri) {
            (Some(view), _) => {
                image(inside, &|| self.buffers.view(view.0).map(|(bytes, _)| bytes.to_vec()))
            }
            (None, Some(uri)) if uri.starts_with("data:") => {
                image(inside, &|| load_uri(uri, folder))
            }
            (None, Some(uri)) => {
                let place = (folder.join(percent_decoded(uri)), None);
                image(place, &|| load_uri(uri, folder))
            }
            (None, None) => Err(malformed("it has neither a URI nor a view".to_owned())),
        }
        .map_err(|error| at_place(error, &Place::Named(format!("image {index}")).to_string()))
    }
}

/// The image of a texture: one that is read, if there are several.
fn source(texture: &Texture) -> Option<usize> {
    let others = &texture.extensions;
    let others = [&others.webp, &others.basis, &others.avif, &others.dds];
    let mut others = others.into_iter().filter_map(|other| other.as_ref()?.source);
    texture.source.or_else(|| others.next()).map(|image| image.0)
}

fn warn_of_transmission(material: &Material, name: &str, warnings: &mut Warnings) {
    let extensions = &material.extensions;
    let through = extensions.transmission.as_ref().map_or(0.0, |at| at.transmission_factor);
    let diffuse =
        extensions.diffuse_transmission.as_ref().map_or(0.0, |at| at.diffuse_transmission_factor);
    if through > 0.0 || diffuse > 0.0 {
        warnings.add(format!(
            "{name}: transmission does not count: it blocks the light that its alpha says"
        ));
    }
}

fn sampled(
    mut texture: AlphaTexture,
    info: &TextureInfo,
    sampler: Option<&Sampler>,
) -> AlphaTexture {
    if let Some(sampler) = sampler {
        texture.wrap = [sampler.wrap_s, sampler.wrap_t].map(|wrap| match wrap.map(|at| at.0) {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        });
        texture.nearest = sampler.mag_filter.is_some_and(|filter| filter.0 == 9728);
    }
    if let Some(transform) = &info.extensions.transform {
        let (sin, cos) = libm::sincosf(transform.rotation);
        // Counterclockwise where v goes down.
        let rotation = glam::Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        let matrix = rotation * glam::Mat2::from_diagonal(Vec2::from(transform.scale));
        texture.uv_transform = Affine2::from_mat2_translation(matrix, Vec2::from(transform.offset));
    }
    texture
}
