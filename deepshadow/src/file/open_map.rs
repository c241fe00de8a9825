//! An open map without its type.

use std::sync::Arc;

use dsm_core::Rgb;
use dsm_io::detail::ErasedMap;
use dsm_scene::TracedScene;
use shadow_maps::detail::FragmentTracer;

use super::texel_hits::TexelHits;
use crate::error::Result;
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::shadow::handle::Shadow;

/// A tracer of a map of fragments.
pub(crate) enum AnyTracer {
    Mono(FragmentTracer<f32>),
    Rgb(FragmentTracer<Rgb>),
}

/// Something exact near a receiver, which short rays go through.
pub(crate) enum Near<'a> {
    /// The scene itself.
    Scene(Arc<TracedScene>),
    /// A map that has a tracer.
    Map(&'a dyn OpenMap),
}

/// An open map of any kind and number of channels.
pub(crate) trait OpenMap: Send + Sync {
    /// The file, for all that is the same for every kind.
    fn file(&self) -> &dyn ErasedMap;

    /// The method of queries that name none.
    fn default_method(&self) -> Method;

    /// The shadows that a query asks for.
    fn shadow(&self, query: &Query) -> Result<Shadow>;

    /// What the map shows through the middle of every pixel, of kinds that tell.
    fn texel_hits(&self) -> Option<Result<TexelHits>> {
        None
    }

    /// The shadows of a query by short rays and lookups, of kinds that have levels for it.
    fn hybrid(&self, _query: &Query, _near: &Near<'_>) -> Option<Result<Shadow>> {
        None
    }

    /// A tracer for short rays, of kinds that have one.
    fn tracer(&self) -> Option<Result<AnyTracer>> {
        None
    }
}
