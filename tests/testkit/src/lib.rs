//! Checks for implementers of [`HitSource`](dsm_core::HitSource),
//! [`OcclusionTracer`](dsm_core::OcclusionTracer) and
//! [`LightVisibility`](dsm_core::LightVisibility).
//!
//! No answer may depend on where a scene stands, on how large its unit is, or on threads
//! and tiles. The checks make an implementation for [`Trial`]s of the same scene, ask
//! each the same, and compare.

mod agreement;
mod answers;
mod config;
mod disagreement;
mod function_kind;
mod hit_source;
mod light_visibility;
mod occlusion_tracer;
mod placement;
mod random;
mod trial;

pub use agreement::Agreement;
pub use answers::check_answers;
pub use config::{config, is_long};
pub use disagreement::Disagreement;
pub use function_kind::FunctionKind;
pub use hit_source::check_hit_source;
pub use light_visibility::check_light_visibility;
pub use occlusion_tracer::check_occlusion_tracer;
pub use placement::Placement;
pub use random::Random;
pub use trial::Trial;
