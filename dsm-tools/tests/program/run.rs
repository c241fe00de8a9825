//! Runs the program.

use std::ffi::OsStr;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// The program with these arguments.
pub(crate) fn program<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dsm-tools"));
    command.args(arguments).stdin(Stdio::null());
    command
}

/// What the program said and how it exited.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Answer {
    /// Holds the program to a success that says nothing on stderr.
    #[track_caller]
    pub(crate) fn stdout(self) -> String {
        assert_eq!((self.code, self.stderr.as_str()), (0, ""), "{}", self.stdout);
        self.stdout
    }

    /// Holds the program to a success that says nothing but warnings on stderr, one of them
    /// with `text` in it; what it printed.
    #[track_caller]
    pub(crate) fn warned(self, text: &str) -> String {
        assert_eq!(self.code, 0, "{self:?}");
        assert!(self.stderr.lines().all(|line| line.starts_with("warning: ")), "{self:?}");
        assert!(self.stderr.lines().any(|line| line.contains(text)), "{self:?}");
        self.stdout
    }

    /// The one JSON document that a successful program prints.
    #[track_caller]
    pub(crate) fn json(self) -> Value {
        serde_json::from_str(&self.stdout()).unwrap()
    }

    /// Holds the program to exit code 1 and one line that begins with
    /// `error: `, which is returned.
    #[track_caller]
    pub(crate) fn refusal(&self) -> &str {
        assert_eq!(self.code, 1, "{self:?}");
        let line = self.stderr.strip_suffix('\n').unwrap();
        assert!(!line.contains('\n'), "{line}");
        line.strip_prefix("error: ").unwrap_or_else(|| panic!("{line}"))
    }

    /// Holds the program to exit code 2 and a message with `text` in it.
    #[track_caller]
    pub(crate) fn is_wrong_usage(&self, text: &str) {
        assert_eq!((self.code, self.stdout.as_str()), (2, ""), "{self:?}");
        assert!(self.stderr.contains(text), "{self:?}");
    }
}

impl From<Output> for Answer {
    fn from(output: Output) -> Self {
        Self {
            // A signal has no code; a panic has 101.
            code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// Runs the program to its end.
pub(crate) fn run<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Answer {
    program(arguments).output().unwrap().into()
}

/// The arguments of a call, of any types that paths and strings are.
#[macro_export]
macro_rules! run {
    ($($argument:expr),* $(,)?) => {
        $crate::run::run([$(std::ffi::OsString::from(&$argument)),*])
    };
}
