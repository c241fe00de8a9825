//! Opacity of surfaces: a factor, a texture, a cutoff.

use std::sync::Arc;

use glam::{Affine2, Vec2};

use crate::error::{Error, Place, Result};

/// The extension of a texture outside [0, 1].
///
/// ```
/// use dsm_scene::detail::{AlphaTexture, Wrap};
/// use glam::Vec2;
///
/// let mut texture = AlphaTexture::new(2, 1, vec![0, 255])?;
/// texture.nearest = true;
/// assert_eq!(texture.sample(Vec2::new(1.25, 0.5)), 0.0);
/// texture.wrap = [Wrap::Clamp; 2];
/// assert_eq!(texture.sample(Vec2::new(1.25, 0.5)), 1.0);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Repeats it.
    #[default]
    Repeat,
    /// Repeats it, mirrored every other time.
    Mirror,
    /// Extends its edge.
    Clamp,
}

impl Wrap {
    /// The texel that stands at `index` of a row of `size`.
    fn texel(self, index: i64, size: i64) -> usize {
        let wrapped = match self {
            Self::Repeat => index.rem_euclid(size),
            Self::Mirror => {
                let turn = index.rem_euclid(2 * size);
                turn.min(2 * size - 1 - turn)
            }
            Self::Clamp => index.clamp(0, size - 1),
        };
        wrapped as usize
    }
}

/// The alpha channel of an image; u right, v down, as in glTF.
///
/// ```
/// use dsm_scene::detail::AlphaTexture;
/// use glam::Vec2;
///
/// let texture = AlphaTexture::new(2, 1, vec![0, 255])?;
/// assert_eq!(texture.sample(Vec2::new(0.25, 0.5)), 0.0);
/// // Between the centres of the two texels.
/// assert_eq!(texture.sample(Vec2::new(0.5, 0.5)), 0.5);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaTexture {
    width: u32,
    height: u32,
    texels: Arc<[u8]>,
    /// Extension beyond the left and right, and the upper and lower edge.
    pub wrap: [Wrap; 2],
    /// True for the nearest texel; otherwise four are interpolated.
    pub nearest: bool,
    /// The transform from the mesh's uv to the texture's.
    pub uv_transform: Affine2,
}

impl AlphaTexture {
    /// A repeated, interpolated texture of `width` × `height` alphas in rows
    /// from the top, 255 opaque.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] if it is empty or `texels` has another length.
    pub fn new(width: u32, height: u32, texels: impl Into<Arc<[u8]>>) -> Result<Self> {
        let texels = texels.into();
        if texels.is_empty() || u64::from(width) * u64::from(height) != texels.len() as u64 {
            return Err(Error::malformed(Place::Whole, "a texture needs width × height texels"));
        }
        let (wrap, uv_transform) = ([Wrap::Repeat; 2], Affine2::IDENTITY);
        Ok(Self { width, height, texels, wrap, nearest: false, uv_transform })
    }

    /// Bytes of its texels.
    pub(crate) fn bytes(&self) -> u64 {
        self.texels.len() as u64
    }

    /// The texture with `value` of each texel in place of it; both in [0, 1].
    pub(crate) fn mapped(self, value: impl Fn(f32) -> f32) -> Self {
        let code = |texel: &u8| (value(f32::from(*texel) / 255.0) * 255.0).round() as u8;
        Self { texels: self.texels.iter().map(code).collect(), ..self }
    }

    /// The alpha at `uv`, in [0, 1]; 1 where `uv` is not finite.
    #[must_use]
    pub fn sample(&self, uv: Vec2) -> f32 {
        let uv = self.uv_transform.transform_point2(uv);
        let at = uv * Vec2::new(self.width as f32, self.height as f32);
        if !at.is_finite() {
            return 1.0;
        }
        let texel = |x: i64, y: i64| {
            let x = self.wrap[0].texel(x, i64::from(self.width));
            let y = self.wrap[1].texel(y, i64::from(self.height));
            f32::from(self.texels[y * self.width as usize + x]) / 255.0
        };
        if self.nearest {
            return texel(at.x.floor() as i64, at.y.floor() as i64);
        }
        let corner = (at - 0.5).floor();
        let part = at - 0.5 - corner;
        // Far from 0 neither is exact, but i64 holds every f32 that is wrapped.
        let limit = 1e15;
        let (x, y) = (corner.x.clamp(-limit, limit) as i64, corner.y.clamp(-limit, limit) as i64);
        let row = |y| texel(x, y) * (1.0 - part.x) + texel(x + 1, y) * part.x;
        row(y) * (1.0 - part.y) + row(y + 1) * part.y
    }
}

/// The use of an alpha value.
///
/// ```
/// use dsm_scene::detail::{Alpha, AlphaMode};
/// use glam::Vec2;
///
/// let opacity = |mode| Alpha { mode, factor: 0.25, texture: None }.opacity(Vec2::ZERO);
/// assert_eq!(opacity(AlphaMode::Opaque), 1.0);
/// assert_eq!(opacity(AlphaMode::Mask(0.5)), 0.0);
/// assert_eq!(opacity(AlphaMode::Blend), 0.25);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Ignored: the surface blocks all light.
    #[default]
    Opaque,
    /// The surface blocks all light where alpha reaches this, and none
    /// elsewhere.
    Mask(f32),
    /// The surface blocks this fraction of the light.
    Blend,
}

/// The opacity of a material.
///
/// ```
/// use dsm_scene::detail::{Alpha, AlphaMode, AlphaTexture};
/// use glam::Vec2;
///
/// let texture = Some(AlphaTexture::new(1, 1, vec![255])?);
/// let leaf = Alpha { mode: AlphaMode::Blend, factor: 0.5, texture };
/// assert_eq!(leaf.opacity(Vec2::ZERO), 0.5);
/// assert!(Alpha::default().is_opaque());
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Alpha {
    /// The use of the alpha value.
    pub mode: AlphaMode,
    /// Factor of the texture, in [0, 1].
    pub factor: f32,
    /// Alpha over the surface; 1 without.
    pub texture: Option<AlphaTexture>,
}

impl Default for Alpha {
    fn default() -> Self {
        Self { mode: AlphaMode::Opaque, factor: 1.0, texture: None }
    }
}

impl Alpha {
    /// True if the opacity is 1 everywhere.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        match self.mode {
            AlphaMode::Opaque => true,
            AlphaMode::Mask(cutoff) => self.texture.is_none() && self.factor >= cutoff,
            AlphaMode::Blend => self.texture.is_none() && self.factor == 1.0,
        }
    }

    /// True if the opacity is the same everywhere, but for what vertices say.
    pub(crate) fn is_even(&self) -> bool {
        self.texture.is_none() || self.mode == AlphaMode::Opaque
    }

    /// The opacity at `uv`, in [0, 1].
    #[must_use]
    pub fn opacity(&self, uv: Vec2) -> f32 {
        self.opacity_times(uv, 1.0)
    }

    /// The opacity at `uv`, in [0, 1], where `vertices` is the alpha between the
    /// vertices: one more factor.
    pub(crate) fn opacity_times(&self, uv: Vec2, vertices: f32) -> f32 {
        let texture = || self.texture.as_ref().map_or(1.0, |t| t.sample(uv));
        let alpha = || self.factor * texture() * vertices;
        match self.mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask(cutoff) => f32::from(alpha() >= cutoff),
            AlphaMode::Blend => alpha().clamp(0.0, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture() -> AlphaTexture {
        AlphaTexture::new(2, 2, [0, 255, 255, 0].as_slice()).unwrap()
    }

    #[test]
    fn textures_interpolate_and_repeat() {
        let texture = texture();
        assert_eq!(texture.sample(Vec2::new(0.25, 0.25)), 0.0);
        assert_eq!(texture.sample(Vec2::new(0.75, 0.25)), 1.0);
        assert_eq!(texture.sample(Vec2::new(0.5, 0.25)), 0.5);
        assert_eq!(texture.sample(Vec2::new(-0.25, 5.25)), 1.0);
        assert_eq!(texture.sample(Vec2::new(0.0, 0.25)), 0.5, "half of the other side");
        let clamped = AlphaTexture { wrap: [Wrap::Clamp; 2], ..texture.clone() };
        assert_eq!(clamped.sample(Vec2::new(-9.0, 0.25)), 0.0);
        let mirrored = AlphaTexture { wrap: [Wrap::Mirror; 2], nearest: true, ..texture.clone() };
        assert_eq!(mirrored.sample(Vec2::new(1.25, 0.25)), 1.0);
        assert_eq!(mirrored.sample(Vec2::new(1.75, 0.25)), 0.0);
        let turned = Affine2::from_scale_angle_translation(Vec2::ONE, 0.0, Vec2::new(0.5, 0.0));
        let moved = AlphaTexture { uv_transform: turned, ..texture };
        assert_eq!(moved.sample(Vec2::new(0.25, 0.25)), 1.0);
    }

    #[test]
    fn odd_coordinates_have_an_alpha() {
        for uv in [f32::NAN, f32::INFINITY, f32::MAX, -f32::MAX, 1e30] {
            let alpha = texture().sample(Vec2::new(uv, 0.25));
            assert!((0.0..=1.0).contains(&alpha), "{uv}: {alpha}");
        }
        assert!(AlphaTexture::new(2, 2, [0; 3].as_slice()).is_err());
        assert!(AlphaTexture::new(0, 0, [].as_slice()).is_err());
    }

    #[test]
    fn a_mask_drops_and_a_blend_attenuates() {
        let uv = Vec2::new(0.45, 0.25);
        let blend = Alpha { mode: AlphaMode::Blend, factor: 0.5, texture: Some(texture()) };
        assert!((blend.opacity(uv) - 0.2).abs() < 1e-6);
        let mask = Alpha { mode: AlphaMode::Mask(0.15), ..blend.clone() };
        assert_eq!(mask.opacity(uv), 1.0);
        let mask = Alpha { mode: AlphaMode::Mask(0.25), ..blend.clone() };
        assert_eq!(mask.opacity(uv), 0.0);
        let opaque = Alpha { mode: AlphaMode::Opaque, ..blend };
        assert!(opaque.is_opaque() && opaque.opacity(uv) == 1.0);
    }
}
