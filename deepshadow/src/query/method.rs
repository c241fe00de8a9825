//! The methods that compute shadows.

use super::attenuation_method::AttenuationMethod;
use super::coherence_method::CoherenceMethod;
use super::filter_method::FilterMethod;
use super::hybrid_method::HybridMethod;
use super::pcf_method::PcfMethod;
use super::prefilter_method::PrefilterMethod;
use super::trace_method::TraceMethod;

/// A way to compute the shadow factor of a point from a map.
///
/// ```
/// use deepshadow::{Method, TraceMethod};
///
/// let method = Method::from(TraceMethod::new(64));
/// assert_eq!(method.name(), "trace");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// Visibility functions, filtered around the point (Lokovic & Veach 2000,
    /// §3.4).
    Filter(FilterMethod),
    /// Shadow rays from the point to the light (Xie et al. 2007, §4.3).
    Trace(TraceMethod),
    /// Percentage closer filtering over the light's outline (Xie et al. 2007,
    /// §3).
    Pcf(PcfMethod),
    /// Lookups in the levels of a prefiltered map (Selgrad et al. 2014, §5).
    Prefilter(PrefilterMethod),
    /// Short rays near the point, lookups beyond.
    Hybrid(HybridMethod),
    /// Lookups in the layers of an attenuation map (Agrawala et al. 2000, §4).
    Attenuation(AttenuationMethod),
    /// Shadow rays where visibility can have changed (Agrawala et al. 2000, §5.2).
    Coherence(CoherenceMethod),
}

impl Method {
    /// The method's name on the command line.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Filter(_) => "filter",
            Self::Trace(_) => "trace",
            Self::Pcf(_) => "pcf",
            Self::Prefilter(_) => "prefilter",
            Self::Hybrid(_) => "hybrid",
            Self::Attenuation(_) => "attenuation",
            Self::Coherence(_) => "coherence",
        }
    }
}

impl From<FilterMethod> for Method {
    fn from(method: FilterMethod) -> Self {
        Self::Filter(method)
    }
}

impl From<TraceMethod> for Method {
    fn from(method: TraceMethod) -> Self {
        Self::Trace(method)
    }
}

impl From<PcfMethod> for Method {
    fn from(method: PcfMethod) -> Self {
        Self::Pcf(method)
    }
}

impl From<PrefilterMethod> for Method {
    fn from(method: PrefilterMethod) -> Self {
        Self::Prefilter(method)
    }
}

impl From<HybridMethod> for Method {
    fn from(method: HybridMethod) -> Self {
        Self::Hybrid(method)
    }
}

impl From<AttenuationMethod> for Method {
    fn from(method: AttenuationMethod) -> Self {
        Self::Attenuation(method)
    }
}

impl From<CoherenceMethod> for Method {
    fn from(method: CoherenceMethod) -> Self {
        Self::Coherence(method)
    }
}
