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

/// The text without what could break a line or move a terminal's cursor,
/// whatever file names and metadata hold.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}
