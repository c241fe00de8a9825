//! Universal Scene Description: text (`.usda`), binary (`.usdc`), either (`.usd`) and
//! packed (`.usdz`).

mod archive;
mod binary;
mod geometry;
mod layer;
mod location;
mod stage;
#[cfg(test)]
mod tests;
mod text;
mod value;

use std::path::Path;

use self::geometry::{items, objects};
use self::location::Location;
use self::stage::Stage;
use self::value::Value;
use super::warnings::Warnings;
use crate::error::Result;
use crate::scene::Object;

/// Reads the objects of a stage at a time, or at its default time.
pub(super) fn load(path: &Path, time: Option<f64>, warnings: &mut Warnings) -> Result<Vec<Object>> {
    let mut stage = Stage::open(Location::of_file(path), warnings)?;
    say_units(&mut stage)?;
    let items = items(&mut stage, time)?;
    objects(items, warnings)
}

/// Says what is left to the scene: lengths and axes stay as the file has them.
fn say_units(stage: &mut Stage<'_>) -> Result<()> {
    if let Some(Value::Words(axis)) = stage.root_field("upAxis")?
        && axis.first().is_some_and(|axis| axis == "Z")
    {
        stage.warnings.add("its up axis is Z: coordinates stay as they are");
    }
    if let Some(Value::Numbers(numbers)) = stage.root_field("metersPerUnit")?
        && let [metres] = numbers.data[..]
        && metres != 1.0
    {
        let line = format!("its units are {metres} m: lengths stay as they are");
        stage.warnings.add(line);
    }
    Ok(())
}
