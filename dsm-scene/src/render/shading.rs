//! Reflection and scattering of the light that arrives, towards the camera.

use glam::DVec3;

use super::interaction::Material;

/// The fraction of light that a material scatters.
const ALBEDO: f64 = 0.8;

/// The part of a strand's light that makes its highlight, and how narrow it is.
const HIGHLIGHT: f64 = 0.35;
const HIGHLIGHT_POWER: i32 = 24;

/// The radiance towards the camera of a material that is fully lit, for a light
/// under which a white surface that faces it has radiance 1. `to_light` and
/// `to_eye` have length 1.
///
/// Surfaces scatter evenly (Lambert), on the side that is seen. Strands are
/// thin cylinders (Kajiya & Kay 1989): the diffuse light is the sine of their
/// angle with the light, the highlight lies on the cone of mirrored rays. Media
/// scatter evenly in all directions, as brightly as a surface that faces the
/// light.
pub(super) fn radiance(material: Material, to_light: DVec3, to_eye: DVec3) -> f64 {
    match material {
        Material::Surface { normal } => ALBEDO * normal.dot(to_light).max(0.0),
        Material::Strand { along, .. } => {
            let sine = |cosine: f64| (1.0 - cosine * cosine).max(0.0).sqrt();
            let (light, eye) = (along.dot(to_light), along.dot(to_eye));
            let mirrored = (sine(light) * sine(eye) - light * eye).max(0.0);
            ALBEDO * (1.0 - HIGHLIGHT) * sine(light) + HIGHLIGHT * mirrored.powi(HIGHLIGHT_POWER)
        }
        Material::Medium => ALBEDO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_are_dark_from_behind_and_strands_along_the_light() {
        let surface = Material::Surface { normal: DVec3::Y };
        let slanted = DVec3::new(0.0, 0.6, 0.8);
        assert!((radiance(surface, slanted, DVec3::Y) - 0.48).abs() < 1e-12);
        assert_eq!(radiance(surface, -slanted, DVec3::Y), 0.0);
        let strand = |along| Material::Strand { along, radius: 0.1 };
        // Away from the highlight, a strand across the light is brightest.
        let aside = DVec3::new(0.8, 0.6, 0.0);
        assert!(radiance(strand(DVec3::X), DVec3::Y, aside) > 0.5);
        assert!(radiance(strand(DVec3::Y), DVec3::Y, aside) < 0.01);
        // The mirror cone: as far beyond the normal plane as the light before.
        let mirrored = DVec3::new(-0.8, 0.0, 0.6);
        let light = DVec3::new(0.8, 0.6, 0.0);
        let aligned = radiance(strand(DVec3::X), light, mirrored);
        assert!((aligned - (ALBEDO * (1.0 - HIGHLIGHT) * 0.6 + HIGHLIGHT)).abs() < 1e-12);
    }
}
