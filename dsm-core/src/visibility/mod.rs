//! Visibility functions: their vertices, evaluation, difference and product.

pub(crate) mod difference;
pub(crate) mod function;
pub(crate) mod moved_depths;
pub(crate) mod polyline;
pub(crate) mod product;
pub(crate) mod search;
pub(crate) mod vertex;
pub(crate) mod vertex_writer;
pub(crate) mod walk;
