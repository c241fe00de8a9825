//! What calls fail with, kept for the thread that made them.

#![expect(unreachable_pub, reason = "C reaches them by their names")]

use std::cell::RefCell;
use std::error::Error;
use std::ffi::{CString, c_char};

/// What became of a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(non_camel_case_types, reason = "a name of C")]
pub enum ds_status {
    /// It did what it should.
    DS_OK = 0,
    /// A map or an image is not what it should be, or cannot be read or written.
    DS_ERROR_FILE = 1,
    /// A scene is not sound.
    DS_ERROR_SCENE = 2,
    /// A map cannot answer what it is asked.
    DS_ERROR_QUERY = 3,
    /// An argument is not what it can be.
    DS_ERROR_SETTING = 4,
    /// A hit source failed.
    DS_ERROR_SOURCE = 5,
    /// A progress function ended the work; no file was changed.
    DS_ERROR_CANCELLED = 6,
    /// A fault of this library.
    DS_ERROR_INTERNAL = 7,
}

/// A status and its message.
#[derive(Debug)]
pub(crate) struct Failure {
    status: ds_status,
    message: String,
}

/// Results of this crate.
pub(crate) type Result<T, E = Failure> = std::result::Result<T, E>;

thread_local! {
    static LAST: RefCell<CString> = RefCell::new(CString::default());
}

impl Failure {
    /// That an argument is not what it can be.
    pub(crate) fn setting(reason: impl Into<String>) -> Self {
        Self { status: ds_status::DS_ERROR_SETTING, message: reason.into() }
    }

    /// A fault of this library.
    pub(crate) fn internal(message: String) -> Self {
        Self { status: ds_status::DS_ERROR_INTERNAL, message }
    }

    /// Keeps the message for this thread.
    pub(crate) fn keep(self) -> ds_status {
        // C's strings end at a zero.
        let message = CString::new(self.message.replace('\0', "\u{fffd}")).unwrap_or_default();
        LAST.with(|last| last.replace(message));
        self.status
    }
}

/// The message that this thread kept last; empty if none. Stays until its next failure.
pub(crate) fn last_message() -> *const c_char {
    LAST.with(|last| last.borrow().as_ptr())
}

impl From<deepshadow::Error> for Failure {
    fn from(error: deepshadow::Error) -> Self {
        use deepshadow::Error as E;

        let status = match &error {
            E::File(inner) => of_file(inner),
            E::Scene(_) => ds_status::DS_ERROR_SCENE,
            E::Query { .. } => ds_status::DS_ERROR_QUERY,
            E::Occluders(_) => ds_status::DS_ERROR_SOURCE,
            E::Interrupted => ds_status::DS_ERROR_CANCELLED,
            _ => ds_status::DS_ERROR_SETTING,
        };
        Self { status, message: whole_message(&error) }
    }
}

impl From<deepshadow::files::Error> for Failure {
    fn from(error: deepshadow::files::Error) -> Self {
        deepshadow::Error::from(error).into()
    }
}

impl From<deepshadow::visibility::Error> for Failure {
    fn from(error: deepshadow::visibility::Error) -> Self {
        deepshadow::Error::from(error).into()
    }
}

impl From<deepshadow::scene::Error> for Failure {
    fn from(error: deepshadow::scene::Error) -> Self {
        deepshadow::Error::from(error).into()
    }
}

impl From<deepshadow::files::deep_exr::Error> for Failure {
    fn from(error: deepshadow::files::deep_exr::Error) -> Self {
        deepshadow::files::Error::from(error).into()
    }
}

fn of_file(error: &deepshadow::files::Error) -> ds_status {
    use deepshadow::files::Error as E;

    match error {
        E::File(inner) => of_file(&inner.error),
        E::Shared(inner) => of_file(inner),
        E::Interrupted => ds_status::DS_ERROR_CANCELLED,
        E::HitSource(_) => ds_status::DS_ERROR_SOURCE,
        E::Setting(_) | E::Mismatch(_) | E::Core(_) => ds_status::DS_ERROR_SETTING,
        _ => ds_status::DS_ERROR_FILE,
    }
}

/// The message of an error and of its causes, in one line.
fn whole_message(error: &dyn Error) -> String {
    let mut message = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        message = format!("{message}: {error}");
        cause = error.source();
    }
    message
}
