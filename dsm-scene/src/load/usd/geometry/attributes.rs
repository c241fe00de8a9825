//! Attributes of prims as numbers and words.

use super::Reader;
use crate::error::{Error, Place, Result};
use crate::load::usd::stage::{Prim, Stage};
use crate::load::usd::value::{Numbers, Value};

/// An attribute of numbers.
pub(super) fn numbers(
    prim: &Prim,
    stage: &Stage<'_>,
    name: &str,
    time: Option<f64>,
) -> Result<Option<Numbers>> {
    Ok(match prim.attribute(stage, name, time)? {
        Some(Value::Numbers(numbers)) => Some(numbers),
        _ => None,
    })
}

/// An attribute of tokens.
pub(super) fn words(
    prim: &Prim,
    stage: &Stage<'_>,
    name: &str,
    time: Option<f64>,
) -> Result<Option<Vec<String>>> {
    Ok(match prim.attribute(stage, name, time)? {
        Some(Value::Words(words)) => Some(words),
        _ => None,
    })
}

/// An error of a prim.
pub(super) fn broken(prim: &Prim, reason: impl Into<String>) -> Error {
    Error::malformed(Place::Named(prim.path.clone()), reason.into())
}

/// Whole numbers ≥ 0.
pub(super) fn indices(prim: &Prim, name: &str, numbers: &Numbers) -> Result<Vec<u32>> {
    let index = |&number: &f64| {
        let is_index = (0.0..=f64::from(u32::MAX)).contains(&number);
        is_index
            .then_some(number as u32)
            .ok_or_else(|| broken(prim, format!("{name} has {number}")))
    };
    numbers.data.iter().map(index).collect()
}

/// How values are spread over a prim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spread {
    Constant,
    /// One a face or strand.
    Uniform,
    /// One a point that the surface goes through.
    Varying,
    /// One a control point.
    Vertex,
    /// One a corner of each face.
    FaceVarying,
}

impl Spread {
    fn of(name: Option<&str>, usual: Self) -> Self {
        match name {
            Some("constant") => Self::Constant,
            Some("uniform") => Self::Uniform,
            Some("varying") => Self::Varying,
            Some("vertex") => Self::Vertex,
            Some("faceVarying") => Self::FaceVarying,
            _ => usual,
        }
    }
}

/// A number all over a prim.
pub(super) struct Primvar {
    pub(super) spread: Spread,
    pub(super) data: Vec<f64>,
}

impl Reader<'_, '_> {
    pub(super) fn numbers(&self, prim: &Prim, name: &str) -> Result<Option<Numbers>> {
        numbers(prim, self.stage, name, self.time)
    }

    /// Vectors, or none.
    pub(super) fn vectors(&self, prim: &Prim, name: &str) -> Result<Option<Vec<[f64; 3]>>> {
        let Some(numbers) = self.numbers(prim, name)? else { return Ok(None) };
        if numbers.size != 3 && !numbers.data.is_empty() {
            return Err(broken(prim, format!("{name} are no vectors")));
        }
        Ok(Some(numbers.data.as_chunks::<3>().0.to_vec()))
    }

    pub(super) fn word(&self, prim: &Prim, name: &str, usual: &str) -> Result<String> {
        let words = words(prim, self.stage, name, self.time)?;
        Ok(words.and_then(|words| words.into_iter().next()).unwrap_or_else(|| usual.to_owned()))
    }

    /// A primvar of numbers, with its indices followed.
    pub(super) fn primvar(
        &mut self,
        prim: &Prim,
        name: &str,
        usual: Spread,
    ) -> Result<Option<Primvar>> {
        let Some(Numbers { size: 1, data, .. }) = self.numbers(prim, name)? else {
            return Ok(None);
        };
        let spread = Spread::of(prim.interpolation(self.stage, name), usual);
        let Some(indices) = self.numbers(prim, &format!("{name}:indices"))? else {
            return Ok(Some(Primvar { spread, data }));
        };
        let data = indices.data.iter().map(|&at| data.get(at as usize).copied());
        match data.collect() {
            Some(data) => Ok(Some(Primvar { spread, data })),
            None => {
                let line = format!("{}: indices of {name} are out of range", prim.path);
                self.stage.warnings.add(line);
                Ok(None)
            }
        }
    }

    /// Widths, of which the primvar counts before the attribute.
    pub(super) fn widths(&mut self, prim: &Prim) -> Result<Primvar> {
        for name in ["primvars:widths", "widths"] {
            let usual = if name == "widths" { Spread::Vertex } else { Spread::Constant };
            if let Some(widths) = self.primvar(prim, name, usual)? {
                if widths.data.iter().all(|width| width.is_finite()) {
                    return Ok(widths);
                }
                return Err(broken(prim, "widths must be finite"));
            }
        }
        self.stage.warnings.add(format!("{}: without widths they count as 1", prim.path));
        Ok(Primvar { spread: Spread::Constant, data: vec![1.0] })
    }

    /// A prim's own opacity.
    pub(super) fn opacity(&mut self, prim: &Prim) -> Result<Option<Primvar>> {
        let found = self.primvar(prim, "primvars:displayOpacity", Spread::Constant)?;
        let Some(mut opacity) = found.filter(|opacity| !opacity.data.is_empty()) else {
            return Ok(None);
        };
        for value in &mut opacity.data {
            // NaN as well.
            *value = if *value > 0.0 { value.min(1.0) } else { 0.0 };
        }
        Ok(Some(opacity))
    }
}
