//! Usage errors in one line, as all errors are.

use clap::Error;
use clap::error::ErrorKind;

use crate::output::printable;

/// The error and what may have been meant, without the usage; none of help and of the version,
/// which are printed as they are.
pub(crate) fn line(error: &Error) -> Option<String> {
    let is_help = matches!(
        error.kind(),
        ErrorKind::DisplayHelp
            | ErrorKind::DisplayVersion
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    );
    (!is_help).then(|| one_line(&error.render().to_string()))
}

fn one_line(text: &str) -> String {
    let end =
        ["\nUsage:", "\nFor more information"].iter().filter_map(|mark| text.find(mark)).min();
    let mut line = String::new();
    for part in text[..end.unwrap_or(text.len())].lines().map(str::trim) {
        if part.is_empty() {
            continue;
        }
        let is_value = part.starts_with('[') || line.ends_with(':');
        line += if line.is_empty() {
            ""
        } else if is_value {
            " "
        } else if part.starts_with("tip:") {
            "; "
        } else {
            ", "
        };
        line += part;
    }
    printable(&format!("{line}; --help tells more"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_and_what_was_meant_are_one_line() {
        let text = "error: invalid value 'a' for '--kind <KIND>'\n  [possible values: deep, views]\n\n  \
                    tip: a similar value exists: 'deep'\n\nFor more information, try '--help'.\n";
        let line = "error: invalid value 'a' for '--kind <KIND>' [possible values: deep, views]; \
                    tip: a similar value exists: 'deep'; --help tells more";
        assert_eq!(one_line(text), line);
        let missing = "error: the following required arguments were not provided:\n  --points <P>\n  \
                       <MAP>\n\nUsage: x\n";
        let line = "error: the following required arguments were not provided: --points <P>, <MAP>; \
                    --help tells more";
        assert_eq!(one_line(missing), line);
    }
}
