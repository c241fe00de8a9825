//! An open map without its type.

use dsm_io::detail::ErasedMap;

use crate::error::Result;
use crate::query::method::Method;
use crate::query::settings::Query;
use crate::shadow::handle::Shadow;

/// An open map of any kind and number of channels.
pub(crate) trait OpenMap: Send + Sync {
    /// The file, for all that is the same for every kind.
    fn file(&self) -> &dyn ErasedMap;

    /// The method of queries that name none.
    fn default_method(&self) -> Method;

    /// The shadows that a query asks for.
    fn shadow(&self, query: &Query) -> Result<Shadow>;
}
