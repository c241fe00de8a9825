//! Methods by their names and options.

use dsm_core::{Bias, FilterShape, Footprint, LevelChoice};
use mtsm::detail::LeafRule;
use shadow_maps::detail::Accumulate;

use super::attenuation_method::AttenuationMethod;
use super::coherence_method::CoherenceMethod;
use super::filter_method::FilterMethod;
use super::hybrid_method::HybridMethod;
use super::method::Method;
use super::pcf_method::PcfMethod;
use super::prefilter_method::PrefilterMethod;
use super::trace_method::{FarTable, TraceMethod};
use crate::error::{Error, Result};

/// A method by its name, with the options that were given: what programs in other
/// languages state, as the program `dsm-tools lookup` does, with its names and defaults.
///
/// ```
/// use deepshadow::{FilterMethod, MethodOptions};
///
/// let rays = MethodOptions { rays: Some(64), ..MethodOptions::default() };
/// let traced = MethodOptions { method: Some("trace".to_owned()), ..rays.clone() };
/// assert_eq!(traced.method(FilterMethod::POINT.into())?.name(), "trace");
/// // A filter has no rays.
/// assert!(rays.method(FilterMethod::POINT.into()).is_err());
/// # Ok::<(), deepshadow::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MethodOptions {
    /// The name of a method. None: the map's own.
    pub method: Option<String>,
    /// The footprint of a filter, in pixels of level 0. None: a point. Method `filter`.
    pub footprint: Option<Footprint>,
    /// The mip level. None: the finest. Method `filter`.
    pub level: Option<LevelChoice>,
    /// The depth bias in scene units, or of method `trace` the ray offset. None: 0 of
    /// methods `filter` and `pcf`, else what suits the map. [`Bias::Auto`] is for `filter`.
    pub bias: Option<Bias>,
    /// Shadow rays or taps of a point, at least 1. None: 256, of method `hybrid` 16.
    pub rays: Option<u32>,
    /// The rule for layers of several samples. Method `trace`.
    pub rule: Option<LeafRule>,
    /// The reach of a sample in depth, in scene units. Method `trace`.
    pub depth_threshold: Option<f64>,
    /// The use of a far table. Method `trace`.
    pub far_table: Option<FarTable>,
    /// How opacities come together. Methods `prefilter` and `hybrid`.
    pub accumulate: Option<Accumulate>,
    /// Parts along the light's shorter side, from 1 to 64. Methods `prefilter` and `hybrid`.
    pub splits: Option<u32>,
    /// How far short rays go, in texels of the finest level. Method `hybrid`.
    pub reach: Option<f64>,
}

/// Rays or taps unless another number is given.
const RAYS: u32 = 256;

impl MethodOptions {
    /// The method of this name and these options; `default` is that of the map.
    ///
    /// A method that this type has no options for is taken from `default`, so that maps
    /// of any kind are queried in their own way.
    ///
    /// # Errors
    ///
    /// [`Error::Unsupported`] for a name that is none, or for an option of other methods.
    pub fn method(&self, default: Method) -> Result<Method> {
        let name = self.method.as_deref().unwrap_or(default.name());
        self.check(name)?;
        Ok(match name {
            "filter" => FilterMethod {
                footprint: self.footprint.unwrap_or(Footprint::Point),
                level: self.level.unwrap_or(LevelChoice::FINEST),
                bias: self.bias.unwrap_or(Bias::Depth(0.0)),
            }
            .into(),
            "trace" => self.trace().into(),
            "pcf" => PcfMethod::new(self.rays.unwrap_or(RAYS))
                .with_bias(self.depth_bias().unwrap_or(0.0))
                .into(),
            "prefilter" => self.prefilter().into(),
            "hybrid" => {
                let hybrid = HybridMethod::default().with_lookup(self.prefilter());
                let rays = self.rays.unwrap_or(hybrid.rays);
                HybridMethod { rays, reach: self.reach.or(hybrid.reach), ..hybrid }.into()
            }
            "attenuation" => {
                AttenuationMethod { bias: self.depth_bias(), bilinear: self.is_bilinear()? }.into()
            }
            "coherence" => self.coherence()?.into(),
            other if other == default.name() => default,
            other => {
                let known = "filter, trace, pcf, prefilter, hybrid, attenuation and coherence";
                return refuse(format!("there is no method {other} for this map: {known} are"));
            }
        })
    }

    /// Refuses the options of other methods.
    fn check(&self, name: &str) -> Result<()> {
        let is_auto = self.bias == Some(Bias::Auto);
        let options: [(&str, bool, &[&str]); 11] = [
            ("filter and width", self.footprint.is_some(), &["filter", "attenuation"]),
            ("level", self.level.is_some(), &["filter"]),
            ("a bias of its own for every point", is_auto, &["filter"]),
            (
                "bias",
                self.bias.is_some() && !is_auto,
                &["filter", "trace", "pcf", "prefilter", "hybrid", "attenuation", "coherence"],
            ),
            ("rays", self.rays.is_some(), &["trace", "pcf", "hybrid", "coherence"]),
            ("rule", self.rule.is_some(), &["trace"]),
            ("z_threshold", self.depth_threshold.is_some(), &["trace"]),
            ("far_table", self.far_table.is_some(), &["trace"]),
            ("accumulate", self.accumulate.is_some(), &["prefilter", "hybrid"]),
            ("splits", self.splits.is_some(), &["prefilter", "hybrid"]),
            ("reach", self.reach.is_some(), &["hybrid"]),
        ];
        for (option, is_given, methods) in options {
            if is_given && !methods.contains(&name) {
                let methods = methods.join(", ");
                return refuse(format!("{option}: not for method {name}, but for {methods}"));
            }
        }
        if ["trace", "coherence"].contains(&name)
            && self.depth_bias().is_some_and(|bias| bias < 0.0)
        {
            return refuse("bias: a ray offset is not negative".to_owned());
        }
        if self.rays == Some(0) {
            return refuse("rays: at least 1".to_owned());
        }
        Ok(())
    }

    fn depth_bias(&self) -> Option<f64> {
        match self.bias {
            Some(Bias::Depth(bias)) => Some(bias.into()),
            _ => None,
        }
    }

    fn trace(&self) -> TraceMethod {
        TraceMethod {
            start: self.depth_bias(),
            rule: self.rule,
            depth_threshold: self.depth_threshold,
            far_table: self.far_table,
            ..TraceMethod::new(self.rays.unwrap_or(RAYS))
        }
    }

    /// Whether four pixels of an attenuation map are interpolated: by the narrowest tent.
    fn is_bilinear(&self) -> Result<bool> {
        match self.footprint {
            None | Some(Footprint::Point) => Ok(false),
            Some(Footprint::Isotropic(filter))
                if filter.shape() == FilterShape::Tent
                    && filter.width() == FilterShape::Tent.minimum_width() =>
            {
                Ok(true)
            }
            Some(_) => refuse(
                "filter: of method attenuation it is point, or tent for four pixels, of width 2"
                    .to_owned(),
            ),
        }
    }

    fn coherence(&self) -> Result<CoherenceMethod> {
        let Some(method) = CoherenceMethod::with_rays(self.rays.unwrap_or(RAYS)) else {
            return refuse("rays: a square number, 1 to 65536, of method coherence".to_owned());
        };
        Ok(self.depth_bias().map_or(method, |start| method.with_start(start)))
    }

    fn prefilter(&self) -> PrefilterMethod {
        PrefilterMethod {
            accumulate: self.accumulate,
            bias: self.depth_bias(),
            splits: self.splits,
        }
    }
}

fn refuse<T>(reason: String) -> Result<T> {
    Err(Error::Unsupported(reason))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dsm_core::Filter;

    fn options(method: &str) -> MethodOptions {
        MethodOptions { method: Some(method.to_owned()), ..MethodOptions::default() }
    }

    #[test]
    fn names_make_methods_with_the_programs_defaults() {
        let default = Method::from(FilterMethod::POINT);
        let made = |name: &str| options(name).method(default).unwrap();
        assert_eq!(made("filter"), FilterMethod::POINT.into());
        assert_eq!(made("trace"), TraceMethod::new(256).into());
        assert_eq!(made("pcf"), PcfMethod::new(256).with_bias(0.0).into());
        assert_eq!(made("prefilter"), PrefilterMethod::new().into());
        assert_eq!(made("hybrid"), HybridMethod::default().into());
        assert_eq!(made("attenuation"), AttenuationMethod::new().into());
        assert_eq!(made("coherence"), CoherenceMethod::new(16).into());
        let tent = Filter::new(FilterShape::Tent, 2.0).unwrap();
        let four = MethodOptions {
            footprint: Some(Footprint::Isotropic(tent)),
            bias: Some(Bias::Depth(0.5)),
            ..options("attenuation")
        };
        let want = AttenuationMethod::new().with_bilinear(true).with_bias(0.5);
        assert_eq!(four.method(default).unwrap(), want.into());
        let wide = Footprint::Isotropic(Filter::new(FilterShape::Box, 2.0).unwrap());
        let wide = MethodOptions { footprint: Some(wide), ..options("attenuation") };
        assert!(wide.method(default).unwrap_err().to_string().contains("four pixels"));
        let few = MethodOptions { rays: Some(99), ..options("coherence") };
        assert!(few.method(default).unwrap_err().to_string().contains("square"));
        assert!(options("shine").method(default).is_err());
    }

    #[test]
    fn options_of_other_methods_are_refused() {
        let default = Method::from(TraceMethod::default());
        let none = MethodOptions::default();
        assert_eq!(none.method(default).unwrap(), TraceMethod::new(256).into());
        let level = MethodOptions { level: Some(LevelChoice::Auto), ..none.clone() };
        assert!(level.method(default).unwrap_err().to_string().contains("method trace"));
        let before = MethodOptions { bias: Some(Bias::Depth(-0.5)), ..none.clone() };
        assert!(before.method(default).is_err());
        assert!(before.method(FilterMethod::POINT.into()).is_ok());
        assert!(MethodOptions { rays: Some(0), ..none }.method(default).is_err());
    }
}
