//! What the commands write.

mod image_samples;
pub(crate) mod image_summary;
pub(crate) mod light;
pub(crate) mod limit;
pub(crate) mod picture;
pub(crate) mod plot;
pub(crate) mod progress;
pub(crate) mod slice;
pub(crate) mod stated;
pub(crate) mod summary;
pub(crate) mod warnings;
pub(crate) mod written;

/// Longer texts out of files are cut off: nobody reads them on a terminal.
const MOST_LETTERS: usize = 2000;

/// The text without what could break a line, move a terminal's cursor, turn what follows
/// around or fill the screen, whatever file names and metadata hold.
pub(crate) fn printable(text: &str) -> String {
    // Separators of lines and paragraphs, and what sets the direction of writing.
    let moves = |letter: char| {
        letter.is_control()
            || matches!(letter, '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    let mut letters = text.chars().map(|letter| if moves(letter) { ' ' } else { letter });
    let mut line: String = letters.by_ref().take(MOST_LETTERS).collect();
    match letters.count() {
        0 => {}
        more => line += &format!("… and {more} more letters"),
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_moves_the_terminal_or_fills_it() {
        assert_eq!(printable("a\x1b[2J\r\n\u{202e}b\u{2028}c"), "a [2J   b c");
        let long = printable(&"n".repeat(65_536));
        assert_eq!(long, format!("{}… and 63536 more letters", "n".repeat(MOST_LETTERS)));
    }
}
