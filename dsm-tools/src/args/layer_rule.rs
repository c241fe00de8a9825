//! The switches that say how shadow rays meet layers.

use clap::{Args, ValueEnum};
use deepshadow::{LeafRule, TraceMethod};

use super::values;

/// Rules by which rays meet layers that have a depth alone.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct LayerFlags {
    /// Loss of a ray at each sample of a layer: the same share of its light
    /// (v_i / v_i-1)^(1 / count), or dv = (v_i-1 - v_i) / count (trace, of kind
    /// mtsm or layers) [default: ratio]
    #[arg(long, value_enum)]
    rule: Option<RuleName>,
    /// Reach of a sample in depth to either side, in scene units (trace,
    /// of kind mtsm or layers) [default: 0]
    #[arg(long, value_name = "Z", allow_negative_numbers = true)]
    #[arg(value_parser = values::length)]
    z_threshold: Option<f32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RuleName {
    Ratio,
    Subtract,
}

impl LayerFlags {
    /// The refusal of the switches where no layers are traced.
    pub(super) const NOT_TRACED: &str = "--rule and --z-threshold are for --method trace";

    /// True if any was given.
    pub(super) const fn is_given(self) -> bool {
        self.rule.is_some() || self.z_threshold.is_some()
    }

    /// The method with these rules.
    pub(super) fn set(self, mut method: TraceMethod) -> TraceMethod {
        if let Some(rule) = self.rule {
            method = method.with_rule(match rule {
                RuleName::Ratio => LeafRule::Ratio,
                RuleName::Subtract => LeafRule::Subtract,
            });
        }
        match self.z_threshold {
            Some(threshold) => method.with_depth_threshold(threshold.into()),
            None => method,
        }
    }
}
