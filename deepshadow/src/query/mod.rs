//! Queries: methods, filters and lights.

mod filter_method;
mod method;
mod pcf_method;
mod settings;
mod trace_method;

pub use filter_method::FilterMethod;
pub use method::Method;
pub use pcf_method::PcfMethod;
pub use settings::Query;
pub use trace_method::{FarTable, TraceMethod};
