//! OpenVDB fog volumes.

use std::io::Cursor;
use std::path::Path;

use glam::{DVec3, IVec3};
use vdb_rs::{Map, VdbLevel, VdbReader};

use super::read_file;
use super::vdb_layout::{check_grid, grids};
use crate::error::{Error, Place, Result};
use crate::volume::{Volume, VolumeBuilder};

pub(super) fn load(path: &Path) -> Result<Volume> {
    parse(&read_file(path)?)
}

fn parse(bytes: &[u8]) -> Result<Volume> {
    let grids = grids(bytes)?;
    let chosen = grids.iter().find(|grid| grid.name == "density").or(match grids.as_slice() {
        [only] => Some(only),
        _ => None,
    });
    let Some(chosen) = chosen else {
        let names: Vec<_> = grids.iter().map(|grid| grid.name.as_str()).collect();
        let reason = format!("no grid is called density, but: {}", names.join(", "));
        return Err(Error::malformed(Place::Header, reason));
    };
    check_grid(bytes, chosen)?;
    let named = || Place::Named(format!("grid `{}`", chosen.name));
    let broken = |error: vdb_rs::ParseError| Error::malformed(named(), error.to_string());
    let mut reader = VdbReader::new(Cursor::new(bytes)).map_err(broken)?;
    let grid = reader.read_grid::<f32>(&chosen.name).map_err(broken)?;

    let mut builder = VolumeBuilder::default();
    for (index, value, level) in grid.iter() {
        // Whole numbers below 2²⁵, as `check_grid` saw to.
        let index = IVec3::from(index.as_ivec3().to_array());
        match level {
            VdbLevel::Voxel => builder.set(index, value)?,
            level => builder.fill(index, level.scale() as i32, value)?,
        }
    }
    let (voxel_size, translation) = match grid.transform {
        Map::UniformScaleMap { scale_values, .. } => (scale_values, Default::default()),
        Map::ScaleTranslateMap { scale_values, translation, .. } => (scale_values, translation),
    };
    let own = |[x, y, z]: [f64; 3]| DVec3::new(x, y, z);
    builder.build(own(voxel_size.to_array()), own(translation.to_array()))
}
