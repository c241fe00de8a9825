//! Queries: methods, filters and lights.

pub(crate) mod attenuation_method;
pub(crate) mod coherence_method;
pub(crate) mod filter_method;
pub(crate) mod hybrid_method;
pub(crate) mod method;
pub(crate) mod method_options;
pub(crate) mod pcf_method;
pub(crate) mod prefilter_method;
pub(crate) mod settings;
pub(crate) mod trace_method;
