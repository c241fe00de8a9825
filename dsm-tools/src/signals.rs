//! Signals that would end the program where a system call's error should.

/// Makes a write past a limit on the size of files (`ulimit -f`) fail, as on a
/// full disk, instead of ending the program (SIGXFSZ): so that there is an
/// error line and no temporary file is left. Rust does the same for pipes.
#[cfg(unix)]
pub(crate) fn survive_file_size_limit() {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    // That the signal came needn't be known: the write says it. Without the
    // handler the program works as well, so that a failure is none.
    let ignored = Arc::new(AtomicBool::new(false));
    drop(signal_hook::flag::register(signal_hook::consts::SIGXFSZ, ignored));
}

#[cfg(not(unix))]
pub(crate) fn survive_file_size_limit() {}
