//! A whole OpenEXR file.

use dsm_core::Progress;
use dsm_io::MapSource;
use dsm_io::deep_exr::{DeepExrReader, Selection};
use dsm_io::detail::compare;

use super::limits;

/// Reads all rows, in bands of 7, and makes visibility functions of them; of a layer
/// and of channels by name, if it has them, a row each.
///
/// # Panics
///
/// If a file differs from itself.
pub fn deep_exr(bytes: &[u8]) -> bool {
    let open = || DeepExrReader::from_bytes(bytes.to_vec(), None, &limits().images);
    let of_layer = Selection::default().layer("a");
    let names = "Z=b.Z,A=a.A".parse().unwrap_or_default();
    for selection in [of_layer, Selection::default().channels(names)] {
        let reader = DeepExrReader::from_bytes(bytes.to_vec(), selection, &limits().images);
        if let Ok(mut reader) = reader {
            drop(reader.read_rows(0..1));
        }
    }
    let Ok(mut reader) = open() else { return false };
    let height = reader.header().height;
    let mut all_read = true;
    for first in (0..height).step_by(7) {
        match reader.read_rows(first..height.min(first + 7)) {
            Ok(rows) => {
                for pixel in 0..rows.pixel_count() {
                    assert!(rows.z().get(rows.pixel(pixel)).is_some());
                }
            }
            Err(_) => all_read = false,
        }
    }
    let (Ok(first), Ok(second)) = (open(), open()) else { return false };
    let [mut first, mut second] = [first, second].map(|reader| MapSource::Image(Box::new(reader)));
    let difference = compare(&mut first, &mut second, Progress::ignore);
    let same = difference.as_ref().is_ok_and(|found| all_read && found.max() == 0.0);
    assert!(same || difference.is_err(), "{difference:?}");
    difference.is_ok()
}
