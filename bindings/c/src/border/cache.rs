//! Tile caches.

use deepshadow::OpenOptions;

use super::guard::guard;
use super::pointers::{hand_out, release, retain};
use crate::failure::ds_status;

/// Memory for the tiles of many maps.
#[expect(non_camel_case_types, reason = "a name of C")]
pub struct ds_cache(pub(super) OpenOptions);

/// Makes a cache of at most so many bytes, for any number of maps.
///
/// # Safety
///
/// `out` can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_cache_new(bytes: u64, out: *mut *const ds_cache) -> ds_status {
    // SAFETY: the header asks for an `out` that can be written to.
    guard(|| unsafe { hand_out(out, ds_cache(OpenOptions::new().with_cache_bytes(bytes))) })
}

/// Adds a reference, and returns the cache.
///
/// # Safety
///
/// `cache` is NULL or a cache that was not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_cache_retain(cache: *const ds_cache) -> *const ds_cache {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { retain(cache) }
}

/// Takes a reference off; the last one ends the cache. Maps keep the one that they were opened
/// with.
///
/// # Safety
///
/// `cache` is NULL or a cache that was not released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ds_cache_release(cache: *const ds_cache) {
    // SAFETY: the header asks for a handle that was not released.
    unsafe { release(cache) }
}
