//! Values of switches that say how a map is looked up.

use clap::ValueEnum;
use deepshadow::CoherenceMethod;
use deepshadow::visibility::{Bias, Filter, FilterShape, Footprint, LevelChoice};

use super::values;

/// A level, or auto.
pub(super) fn level(text: &str) -> Result<LevelChoice, String> {
    match text.parse::<f64>() {
        _ if text == "auto" => Ok(LevelChoice::Auto),
        Ok(level) if (0.0..f64::INFINITY).contains(&level) => Ok(LevelChoice::Fixed(level)),
        _ => Err("must be auto or a number from 0 on".to_owned()),
    }
}

/// A bias, or auto.
pub(super) fn bias(text: &str) -> Result<Bias, String> {
    if text.trim() == "auto" {
        return Ok(Bias::Auto);
    }
    values::finite(text).map(Bias::Depth)
}

/// The filters that there are, and none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum FilterName {
    Point,
    Box,
    Tent,
    Gaussian,
}

impl FilterName {
    const fn shape(self) -> Option<FilterShape> {
        match self {
            Self::Point => None,
            Self::Box => Some(FilterShape::Box),
            Self::Tent => Some(FilterShape::Tent),
            Self::Gaussian => Some(FilterShape::Gaussian),
        }
    }
}

/// The footprint of a filter of this width; none stands for the minimum.
pub(super) fn footprint(filter: FilterName, width: Option<f32>) -> Result<Footprint, String> {
    match (filter.shape(), width) {
        (None, None) => Ok(Footprint::Point),
        (None, Some(_)) => Err("--width needs a --filter other than point".to_owned()),
        (Some(shape), width) => {
            let width = width.unwrap_or(shape.minimum_width());
            let filter = Filter::new(shape, width).map_err(|error| error.to_string())?;
            Ok(Footprint::Isotropic(filter))
        }
    }
}

/// Whether four pixels of an attenuation map are interpolated: by the narrowest tent.
pub(super) fn is_bilinear(filter: FilterName, width: Option<f32>) -> Result<bool, String> {
    let narrowest = FilterShape::Tent.minimum_width();
    match (filter, width) {
        (FilterName::Point, None) => Ok(false),
        (FilterName::Tent, None) => Ok(true),
        (FilterName::Tent, Some(width)) if width == narrowest => Ok(true),
        _ => Err("--filter of --method attenuation is point, or tent for four pixels, of width 2"
            .to_owned()),
    }
}

/// What is wrong with the rays of coherent sampling.
pub(super) const NO_SQUARE: &str = "--rays: coherence takes a square number of rays, 1 to 65536";

/// Coherent sampling with a ray for each cell of the light; none unless the rays are a
/// square number.
pub(super) fn coherence(rays: u32, start: Option<f64>) -> Option<CoherenceMethod> {
    let method = CoherenceMethod::with_rays(rays)?;
    Some(start.map_or(method, |start| method.with_start(start)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bias_is_a_number_or_auto() {
        assert_eq!(bias("auto"), Ok(Bias::Auto));
        assert_eq!(bias("-0.5"), Ok(Bias::Depth(-0.5)));
        assert!(bias("automatic").is_err() && bias("inf").is_err());
    }
}
