//! The values of a part's attributes.

use super::part::RawPart;
use crate::error::Result;
use crate::window::Window;

impl RawPart {
    /// The value of an attribute of this type and of `N` bytes.
    pub(super) fn value<const N: usize>(
        &self,
        name: &str,
        type_name: &str,
    ) -> Result<Option<[u8; N]>> {
        let Some((attribute, _)) = self.attribute(name) else { return Ok(None) };
        if attribute.type_name != type_name.as_bytes() {
            let found = String::from_utf8_lossy(&attribute.type_name);
            return Err(self.error(name, format!("is of type '{found}', not '{type_name}'")));
        }
        let length = attribute.value.len();
        let value = <[u8; N]>::try_from(attribute.value.as_slice());
        value.map(Some).map_err(|_| self.error(name, format!("has {length} bytes, not {N}")))
    }

    pub(super) fn floats<const N: usize>(
        &self,
        name: &str,
        type_name: &str,
    ) -> Result<Option<[f32; N]>> {
        let Some((attribute, _)) = self.attribute(name) else { return Ok(None) };
        let (words, rest) = attribute.value.as_chunks::<4>();
        let floats = <[[u8; 4]; N]>::try_from(words).ok();
        match floats {
            Some(floats) if rest.is_empty() && attribute.type_name == type_name.as_bytes() => {
                Ok(Some(floats.map(f32::from_le_bytes)))
            }
            _ => Err(self.error(name, format!("is not a '{type_name}' of {} bytes", 4 * N))),
        }
    }

    /// A matrix; one of another type is left to the free attributes.
    pub(super) fn matrix(&self, name: &str) -> Option<[f32; 16]> {
        self.floats(name, "m44f").ok().flatten()
    }

    /// A rectangle of pixels that files may have.
    pub(super) fn window(&self, name: &str) -> Result<Option<Window>> {
        let Some(bytes) = self.value::<16>(name, "box2i")? else { return Ok(None) };
        let (words, _) = bytes.as_chunks::<4>();
        let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|i| i32::from_le_bytes(words[i]));
        let window = Window { min: [x0, y0], max: [x1, y1] };
        if window.is_valid() {
            return Ok(Some(window));
        }
        let reason = if window.size().contains(&0) {
            "has no pixels"
        } else {
            "reaches further than 2^30 pixels"
        };
        Err(self.error(name, format!("({x0}, {y0}) to ({x1}, {y1}) {reason}")))
    }
}

/// What must be there.
pub(super) fn required<T>(part: &RawPart, name: &str, value: Option<T>) -> Result<T> {
    value.ok_or_else(|| part.error(name, "is missing"))
}
