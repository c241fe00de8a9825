//! What a bound of layers a pixel changed.

use deepshadow::detail::Result;
use deepshadow::{Kind, ShadowMap};
use serde_json::Value;

/// The sentence about `pixels` with more layers than a map keeps, and the most light that is
/// too much by that and its mean; none for no such pixels.
pub(crate) fn told(kind: Kind, pixels: u64, [most, mean]: [f64; 2]) -> Option<String> {
    let mut told = format!("{pixels} pixels have more layers than --layers keeps");
    if most > 0.0 {
        told += if kind.has_planes() {
            ": the last stands for the rest, and between them"
        } else {
            ": the rest is left out, and behind the last"
        };
        told += &format!(
            " up to {most:.4} of the light is too much, {mean:.4} in the mean over the map"
        );
    }
    (pixels > 0).then_some(told)
}

/// The same of a map in a file.
pub(crate) fn of_map(map: &ShadowMap) -> Result<Option<String>> {
    let keys = map.kind_metadata()?;
    let cut = keys.get("folded").or(keys.get("left_out"));
    Ok(cut.zip(Kind::named(map.kind())).and_then(|(cut, kind)| {
        let light = ["max", "mean"].map(|key| cut[key].as_f64().unwrap_or(0.0));
        told(kind, cut.get("pixels").and_then(Value::as_u64)?, light)
    }))
}
