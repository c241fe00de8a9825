//! Queries from keyword arguments.

use deepshadow::visibility::{Bias, Filter, FilterShape, Footprint, LevelChoice};
use deepshadow::{Accumulate, FarTable, LeafRule, MethodOptions, Query};
use pyo3::prelude::*;

use crate::error::{Failure, Result};
use crate::light::Light;
use crate::options::Options;

/// A query, and what short rays go through.
pub(crate) struct Asked<'py> {
    options: MethodOptions,
    query: Query,
    /// The argument `near`: a map or a scene.
    pub(crate) near: Option<Bound<'py, PyAny>>,
}

/// The shapes of filters by name.
pub(crate) const SHAPES: [(&str, FilterShape); 3] =
    [("box", FilterShape::Box), ("tent", FilterShape::Tent), ("gaussian", FilterShape::Gaussian)];

/// The ways opacities come together, by name.
pub(crate) const ACCUMULATE: [(&str, Accumulate); 3] =
    [("add", Accumulate::Add), ("multiply", Accumulate::Multiply), ("max", Accumulate::Max)];

impl<'py> Asked<'py> {
    /// The query of a call's keyword arguments, with the names of the program's `lookup`.
    pub(crate) fn take(given: &Options<'py>) -> Result<Self> {
        let options = MethodOptions {
            method: given.take("method")?,
            footprint: footprint(given)?,
            level: given.object("level")?.map(|level| choice(&level)).transpose()?,
            bias: given.object("bias")?.map(|bias| depth_bias(&bias)).transpose()?,
            rays: given.take("rays")?,
            rule: given
                .word("rule", &[("ratio", LeafRule::Ratio), ("subtract", LeafRule::Subtract)])?,
            depth_threshold: given.take::<f32>("z_threshold")?.map(f64::from),
            far_table: given.word(
                "far_table",
                &[("auto", FarTable::Auto), ("on", FarTable::On), ("off", FarTable::Off)],
            )?,
            accumulate: given.word("accumulate", &ACCUMULATE)?,
            splits: given.take("splits")?,
            reach: given.take("reach")?,
        };
        let mut query = Query::new().with_seed(given.take("seed")?.unwrap_or(0));
        if let Some(light) = given.object("light")? {
            query =
                query.with_light(light.cast::<Light>().map_err(PyErr::from)?.get().get().area()?);
        }
        if let Some(size) = given.object("light_size")? {
            let size = match size.extract::<f32>() {
                Ok(side) => [side; 2],
                Err(_) => size.extract()?,
            };
            query = query.with_light_size(size);
        }
        Ok(Self { options, query, near: given.object("near")? })
    }

    /// The query of a map whose own method this is.
    pub(crate) fn query(&self, default: deepshadow::Method) -> Result<Query> {
        let method = self.options.method(default)?;
        let name = method.name();
        if (self.near.is_some()) != (name == "hybrid") {
            let reason = "method hybrid needs near, a map of kind fragments or a scene; others \
                          have no use for it";
            return Err(Failure::setting(reason));
        }
        let has_light = self.query.light.is_some() || self.query.light_size.is_some();
        if has_light && name == "filter" {
            return Err(Failure::setting("light and light_size are not for method filter"));
        }
        Ok(self.query.with_method(method))
    }
}

/// The footprint of `filter` and `width`; `None` for a point.
fn footprint(given: &Options<'_>) -> Result<Option<Footprint>> {
    let shape = given.take::<String>("filter")?.filter(|name| name != "point");
    let width: Option<f32> = given.take("width")?;
    let Some(name) = shape else {
        return match width {
            Some(_) => Err(Failure::setting("width needs a filter other than point")),
            None => Ok(None),
        };
    };
    let Some(&(_, shape)) = SHAPES.iter().find(|(known, _)| *known == name) else {
        let reason = format!("filter: '{name}' is none of point, box, tent, gaussian");
        return Err(Failure::setting(reason));
    };
    let filter = Filter::new(shape, width.unwrap_or(shape.minimum_width()))?;
    Ok(Some(Footprint::Isotropic(filter)))
}

fn choice(given: &Bound<'_, PyAny>) -> Result<LevelChoice> {
    if given.extract::<&str>().is_ok_and(|word| word == "auto") {
        return Ok(LevelChoice::Auto);
    }
    match given.extract::<f64>() {
        Ok(level) if (0.0..f64::INFINITY).contains(&level) => Ok(LevelChoice::Fixed(level)),
        _ => Err(Failure::setting("level: \"auto\" or a number from 0 on")),
    }
}

fn depth_bias(given: &Bound<'_, PyAny>) -> Result<Bias> {
    if given.extract::<&str>().is_ok_and(|word| word == "auto") {
        return Ok(Bias::Auto);
    }
    match given.extract::<f32>() {
        Ok(bias) if bias.is_finite() => Ok(Bias::Depth(bias)),
        _ => Err(Failure::setting("bias: \"auto\" or a finite number of scene units")),
    }
}
