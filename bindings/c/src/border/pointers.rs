//! Pointers of C as references, slices, strings and handles.

use std::ffi::{CStr, OsStr, c_char};
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;
use std::sync::Arc;

use super::guard::guarded;
use crate::failure::{Failure, Result};

fn null(what: &str) -> Failure {
    Failure::setting(format!("{what}: NULL"))
}

/// What `pointer` leads to.
///
/// # Safety
///
/// It is NULL, or leads to a `T` that nobody changes while the reference lives.
pub(super) unsafe fn borrow<'a, T>(pointer: *const T, what: &str) -> Result<&'a T> {
    // SAFETY: not NULL after the check; the rest is the caller's promise.
    unsafe { pointer.as_ref() }.ok_or_else(|| null(what))
}

/// The same of what is changed.
///
/// # Safety
///
/// It is NULL, or leads to a `T` that nobody else uses while the reference lives.
pub(super) unsafe fn borrow_mut<'a, T>(pointer: *mut T, what: &str) -> Result<&'a mut T> {
    // SAFETY: not NULL after the check; the rest is the caller's promise.
    unsafe { pointer.as_mut() }.ok_or_else(|| null(what))
}

/// Writes `value` to where `out` leads, whatever is there.
///
/// # Safety
///
/// It is NULL, or a `T` can be written there.
pub(super) unsafe fn write<T>(out: *mut T, value: T, what: &str) -> Result<()> {
    if out.is_null() {
        return Err(null(what));
    }
    // SAFETY: not NULL; writable by the caller's promise. What was there is not dropped.
    unsafe { out.write(value) };
    Ok(())
}

/// Hands `value` out with one reference.
///
/// # Safety
///
/// As of [`write`].
pub(super) unsafe fn hand_out<T>(out: *mut *const T, value: T) -> Result<()> {
    if out.is_null() {
        return Err(null("out"));
    }
    // SAFETY: as promised to this function.
    unsafe { write(out, Arc::into_raw(Arc::new(value)), "out") }
}

/// Adds a reference to a handle.
///
/// # Safety
///
/// It is NULL, or was handed out by [`hand_out`] and not released as often as it was retained.
pub(super) unsafe fn retain<T>(handle: *const T) -> *const T {
    if !handle.is_null() {
        // SAFETY: it came from `Arc::into_raw` and has a reference left.
        unsafe { Arc::increment_strong_count(handle) };
    }
    handle
}

/// Takes a reference off a handle.
///
/// # Safety
///
/// As of [`retain`].
pub(super) unsafe fn release<T>(handle: *const T) {
    if !handle.is_null() {
        // SAFETY: it came from `Arc::into_raw` and has a reference left, which ends here.
        guarded((), || unsafe { Arc::decrement_strong_count(handle) });
    }
}

/// An array.
///
/// # Safety
///
/// `first` leads to `count` elements that nobody changes while the slice lives, or `count` is 0.
pub(super) unsafe fn slice<'a, T>(first: *const T, count: usize, what: &str) -> Result<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    if first.is_null() {
        return Err(null(what));
    }
    check_size::<T>(count, what)?;
    // SAFETY: not NULL, of a size that can be; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(first, count) })
}

/// An array that is written to.
///
/// # Safety
///
/// `first` leads to `count` initialised elements that nobody else uses while the slice lives, or
/// `count` is 0.
pub(super) unsafe fn slice_mut<'a, T>(
    first: *mut T,
    count: usize,
    what: &str,
) -> Result<&'a mut [T]> {
    if count == 0 {
        return Ok(&mut []);
    }
    if first.is_null() {
        return Err(null(what));
    }
    check_size::<T>(count, what)?;
    // SAFETY: not NULL, of a size that can be; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts_mut(first, count) })
}

fn check_size<T>(count: usize, what: &str) -> Result<()> {
    let bytes = count.checked_mul(size_of::<T>()).filter(|&bytes| isize::try_from(bytes).is_ok());
    bytes.map(|_| ()).ok_or_else(|| Failure::setting(format!("{what}: {count} are too many")))
}

/// A string; `None` for NULL.
///
/// # Safety
///
/// It is NULL, or ends at a zero and stays as it is while the reference lives.
pub(super) unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Result<Option<&'a str>> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: not NULL; it ends at a zero by the caller's promise.
    let text = unsafe { CStr::from_ptr(pointer) };
    let text = text.to_str().map_err(|_| Failure::setting(format!("{what}: not UTF-8")));
    text.map(Some)
}

/// A path.
///
/// # Safety
///
/// As of [`text`].
pub(super) unsafe fn path(pointer: *const c_char, what: &str) -> Result<PathBuf> {
    if pointer.is_null() {
        return Err(null(what));
    }
    // SAFETY: not NULL; it ends at a zero by the caller's promise.
    let bytes = unsafe { CStr::from_ptr(pointer) }.to_bytes();
    Ok(OsStr::from_bytes(bytes).into())
}
