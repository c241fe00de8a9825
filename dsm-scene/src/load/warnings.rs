//! What loaders warn of.

use std::path::Path;

/// A file that says the same in a thousand places is not quoted a thousand times.
const MOST: usize = 16;

/// Sentences about what a file says that was not understood, or was taken in one of
/// several ways, and changes light.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    lines: Vec<String>,
    left_out: usize,
}

impl Warnings {
    /// Adds a sentence without a full stop, unless it is there.
    pub(crate) fn add(&mut self, line: impl Into<String>) {
        let line = one_line(&line.into());
        if self.lines.contains(&line) {
            return;
        }
        if self.lines.len() < MOST {
            self.lines.push(line);
        } else {
            self.left_out += 1;
        }
    }

    /// Adds those of a file, with its name.
    pub(crate) fn add_of_file(&mut self, path: &Path, of_file: Self) {
        let path = path.display();
        self.lines.extend(of_file.lines.into_iter().map(|line| format!("{path}: {line}")));
        if of_file.left_out > 0 {
            self.lines.push(format!("{path}: and {} more warnings", of_file.left_out));
        }
    }

    /// The sentences.
    pub(crate) fn into_lines(self) -> Vec<String> {
        self.lines
    }
}

/// Text of a file as one line of a bounded length.
pub(crate) fn one_line(text: &str) -> String {
    let visible = |letter: char| if letter.is_control() { ' ' } else { letter };
    let words: String = text.chars().map(visible).take(300).collect();
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_are_said_once_and_bounded() {
        let mut of_file = Warnings::default();
        for index in 0..40 {
            of_file.add(format!("material {index}\nis odd"));
            of_file.add("the same");
        }
        let mut all = Warnings::default();
        all.add_of_file(Path::new("a.obj"), of_file);
        let lines = all.into_lines();
        assert_eq!(lines.len(), MOST + 1);
        assert_eq!(lines[0], "a.obj: material 0 is odd");
        assert_eq!(lines[MOST], "a.obj: and 25 more warnings");
        assert!(one_line(&"long ".repeat(1000)).len() <= 300);
    }
}
