//! No panic gets over the border.

use std::any::Any;
use std::ffi::c_char;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::failure::{Failure, Result, ds_status, last_message};

/// Runs `work`; what it fails with is kept for this thread.
pub(super) fn guard(work: impl FnOnce() -> Result<()>) -> ds_status {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => ds_status::DS_OK,
        Ok(Err(failure)) => failure.keep(),
        Err(panic) => Failure::internal(format!("a fault: {}", message(&*panic))).keep(),
    }
}

/// The same for what has no status, such as a release.
pub(super) fn guarded<T>(default: T, work: impl FnOnce() -> T) -> T {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(default)
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("unknown")
}

/// The message of the last failure of a call of this thread; empty if none failed. It stays
/// until the next.
#[unsafe(no_mangle)]
pub extern "C" fn ds_error_message() -> *const c_char {
    last_message()
}

/// The version of this interface: the library's major and minor version, as 100 * major + minor.
/// A program runs with libraries of the same number.
#[unsafe(no_mangle)]
pub extern "C" fn ds_abi_version() -> u32 {
    1
}
