//! How much of a light lies on the side of a surface that is shaded.

use std::f64::consts::PI;

use dsm_core::AreaLight;
use dsm_core::detail::LightShape;
use glam::DVec3;

/// The share of a light's area, of a sphere of the disk that `position` sees, that lies above
/// the plane through `position` with this unit normal: in \[0, 1\].
pub(super) fn share_above(light: &AreaLight, position: DVec3, normal: DVec3) -> f64 {
    let towards = light.centre() - position;
    let height = towards.dot(normal);
    let [right, up] = light.half_axes();
    match light.shape() {
        // A sphere is the last.
        LightShape::Point => half_plane(height),
        LightShape::Rectangle => rectangle(height, right.dot(normal).abs(), up.dot(normal).abs()),
        LightShape::Disk => disk(height, right.dot(normal).hypot(up.dot(normal))),
        _ => {
            let across = towards.normalize_or_zero().cross(normal).length();
            disk(height, right.length() * across)
        }
    }
}

/// All or nothing; all of what is no number.
fn half_plane(height: f64) -> f64 {
    if height <= 0.0 { 0.0 } else { 1.0 }
}

/// Of height + a s + b t, evenly over s and t in [−1, 1], the share above 0.
fn rectangle(height: f64, a: f64, b: f64) -> f64 {
    let (wide, narrow) = (a.max(b), a.min(b));
    if height.abs() >= wide + narrow {
        return half_plane(height);
    }
    let side = if height.abs() <= wide - narrow {
        height.abs() / wide * 0.5
    } else {
        // A corner is cut off.
        0.5 - (wide + narrow - height.abs()).powi(2) / (8.0 * wide * narrow)
    };
    0.5 + side.copysign(height)
}

/// The same over a disk whose height changes by `reach` from its middle to its edge.
fn disk(height: f64, reach: f64) -> f64 {
    if height.abs() >= reach {
        return half_plane(height);
    }
    let x = height / reach;
    0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_counted_samples() {
        let centre = DVec3::new(0.5, 4.0, -1.0);
        let (right, up) = (DVec3::new(1.0, 0.25, 0.0), DVec3::new(-0.1, 0.4, 0.8));
        let lights = [
            AreaLight::point(centre),
            AreaLight::rectangle(centre, right, up),
            AreaLight::disk(centre, right, up),
            AreaLight::sphere(centre, 0.7),
        ];
        for light in lights {
            let mut partly = 0;
            for step in 0..200_u32 {
                let turn = f64::from(step) * 0.37;
                let position = DVec3::new(turn.sin(), (1.3 * turn).cos(), (0.7 * turn).sin());
                // Half of them nearly edge on.
                let across = (centre - position).cross(DVec3::new(0.3, turn.cos(), 0.9));
                let tilt = if step % 2 == 0 { 0.1 * (3.0 * turn).sin() } else { turn.sin() };
                let normal = across.normalize() + (centre - position).normalize() * tilt;
                let normal = normal.normalize();
                let samples = light.samples(position, 4096, 1);
                let above = samples.filter(|&at| (at - position).dot(normal) > 0.0).count();
                let found = share_above(&light, position, normal);
                assert!((found - above as f64 / 4096.0).abs() < 0.01, "{light:?} {found} {above}");
                partly += u32::from((0.05..0.95).contains(&found));
            }
            assert!(partly > 40 || light.shape() == LightShape::Point, "{light:?} {partly}");
        }
    }
}
