//! Transforms of prims.

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::Reader;
use super::attributes::{numbers, words};
use crate::error::Result;
use crate::load::usd::stage::Prim;

/// A prim's transform to its parent's space, or to the world's.
pub(super) struct Local {
    pub(super) matrix: DAffine3,
    /// True if what its parents say does not count.
    pub(super) is_of_world: bool,
}

impl Reader<'_, '_> {
    /// The transform that a prim's operations make, the outermost first.
    pub(super) fn local(&mut self, prim: &Prim) -> Result<Local> {
        let mut local = Local { matrix: DAffine3::IDENTITY, is_of_world: false };
        let Some(order) = words(prim, self.stage, "xformOpOrder", self.time)? else {
            return Ok(local);
        };
        for name in order {
            if name == "!resetXformStack!" {
                local = Local { matrix: DAffine3::IDENTITY, is_of_world: true };
                continue;
            }
            let (name, is_inverse) = match name.strip_prefix("!invert!") {
                Some(name) => (name, true),
                None => (name.as_str(), false),
            };
            let kind = name.strip_prefix("xformOp:").unwrap_or("");
            let kind = kind.split(':').next().unwrap_or("");
            let values = numbers(prim, self.stage, name, self.time)?;
            let Some(matrix) = values.and_then(|values| operation(kind, &values.data)) else {
                let line = format!("{}: {name} is not understood and left out", prim.path);
                self.stage.warnings.add(line);
                continue;
            };
            local.matrix *= if is_inverse { matrix.inverse() } else { matrix };
        }
        if !local.matrix.is_finite() {
            let line = format!("{}: its transform is not finite and left out", prim.path);
            self.stage.warnings.add(line);
            local.matrix = DAffine3::IDENTITY;
        }
        Ok(local)
    }
}

/// One operation as a matrix.
fn operation(kind: &str, values: &[f64]) -> Option<DAffine3> {
    let vector = || values.as_chunks::<3>().0.first().copied().map(DVec3::from);
    let number = || values.first().copied();
    let axes = [('X', DVec3::X), ('Y', DVec3::Y), ('Z', DVec3::Z)];
    let axis = |letter: char| axes.iter().find(|axis| axis.0 == letter).map(|axis| axis.1);
    let turn = |letter: char, degrees: f64| {
        let (sin, cos) = libm::sincos((degrees % 360.0).to_radians());
        let axis = axis(letter)?;
        let column = |unit: DVec3| {
            let along = axis * axis.dot(unit);
            along + (unit - along) * cos + axis.cross(unit) * sin
        };
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(column);
        Some(DAffine3::from_cols(x, y, z, DVec3::ZERO))
    };
    if let Some(letters) = kind.strip_prefix("rotate") {
        let letters: Vec<char> = letters.chars().collect();
        return match letters[..] {
            [letter] => turn(letter, number()?),
            [_, _, _] => {
                let angles = vector()?;
                // The first one is applied first.
                letters.iter().try_fold(DAffine3::IDENTITY, |inner, &letter| {
                    Some(turn(letter, angles.dot(axis(letter)?))? * inner)
                })
            }
            _ => None,
        };
    }
    let unit = |kind: &str, name: &str| {
        let letter = kind.strip_prefix(name)?.chars().next()?;
        axis(letter)
    };
    Some(match kind {
        "translate" => DAffine3::from_translation(vector()?),
        "scale" => DAffine3::from_scale(vector()?),
        "orient" => DAffine3::from_quat(rotation(values)?),
        "transform" => matrix(values)?,
        _ => {
            if let Some(unit) = unit(kind, "translate") {
                DAffine3::from_translation(unit * number()?)
            } else {
                let unit = unit(kind, "scale")?;
                DAffine3::from_scale(DVec3::ONE + unit * (number()? - 1.0))
            }
        }
    })
}

/// The rotation of i, j, k, real. Like the standard's own library, one that is no unit
/// quaternion turns by 2 acos(real) about its axis.
fn rotation(values: &[f64]) -> Option<DQuat> {
    let [x, y, z, real] = *values.first_chunk::<4>()?;
    let axis = DVec3::new(x, y, z).try_normalize().unwrap_or(DVec3::X);
    let half = libm::acos(real.clamp(-1.0, 1.0));
    let (sin, cos) = libm::sincos(half);
    let [x, y, z] = (axis * sin).to_array();
    real.is_finite().then(|| DQuat::from_xyzw(x, y, z, cos))
}

/// A matrix that is applied from the right: its rows are columns here.
fn matrix(values: &[f64]) -> Option<DAffine3> {
    let matrix = DMat4::from_cols_array(values.first_chunk::<16>()?);
    Some(DAffine3::from_mat4(matrix))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_applied_in_the_order_of_their_letters() {
        let found = operation("rotateXZY", &[20.0, 30.0, 40.0]).unwrap();
        let turns = [
            DAffine3::from_rotation_y(30_f64.to_radians()),
            DAffine3::from_rotation_z(40_f64.to_radians()),
            DAffine3::from_rotation_x(20_f64.to_radians()),
        ];
        assert!(found.abs_diff_eq(turns[0] * turns[1] * turns[2], 1e-15));
        assert!(operation("rotateXW", &[1.0]).is_none());
        assert!(operation("translateQ", &[1.0]).is_none());
        assert!(operation("translate", &[1.0]).is_none());
        let scale = operation("scaleY", &[3.0]).unwrap();
        assert_eq!(scale.transform_point3(DVec3::ONE), DVec3::new(1.0, 3.0, 1.0));
    }
}
