//! The maps of grids from index space to the world.

use glam::{DAffine3, DMat3, DVec3};

use super::bytes::Bytes;
use crate::error::Result;

/// Reads a transform: any affine map.
///
/// # Errors
///
/// The name of a map that is none, such as the frusta of cameras.
pub(super) fn read_transform(file: &mut Bytes<'_>) -> Result<DAffine3> {
    let name = file.text()?;
    match name.as_str() {
        "UniformScaleMap" | "ScaleMap" => {
            let scale = vector(file)?;
            // The sizes of voxels and the inverses follow from it.
            (0..4).try_for_each(|_| vector(file).map(drop))?;
            Ok(DAffine3::from_scale(scale))
        }
        "TranslationMap" => Ok(DAffine3::from_translation(vector(file)?)),
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let (translation, scale) = (vector(file)?, vector(file)?);
            (0..4).try_for_each(|_| vector(file).map(drop))?;
            Ok(DAffine3 { matrix3: DMat3::from_diagonal(scale), translation })
        }
        "AffineMap" | "UnitaryMap" => {
            // Row vectors: its rows are the images of the axes.
            let mut rows = [DVec3::ZERO; 4];
            for (index, row) in rows.iter_mut().enumerate() {
                *row = vector(file)?;
                if file.f64()? != f64::from(index == 3) {
                    return Err(file.refuse("a transform that is not affine"));
                }
            }
            let [x, y, z, translation] = rows;
            Ok(DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation })
        }
        _ => Err(file.refuse(format!("unsupported transform {name}: only affine ones"))),
    }
}

fn vector(file: &mut Bytes<'_>) -> Result<DVec3> {
    Ok(DVec3::new(file.f64()?, file.f64()?, file.f64()?))
}
