//! Parts of a map in files of their own.

use dsm_core::detail::PixelWindow;

use crate::error::{Error, Result};
use crate::format::level::Level;
use crate::metadata::Metadata;

/// The pixels of a whole map that one file holds, so that several machines
/// can each make a part. It begins and ends on borders of tiles, or at the
/// whole map's edge.
///
/// The header of a crop is the whole map's;
/// [`MapWriter::create_crop`](crate::writer::MapWriter::create_crop) writes one,
/// [`merge`](crate::merge()) puts crops together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// First column, in pixels of the whole map.
    pub x: u32,
    /// First row, in pixels of the whole map.
    pub y: u32,
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
}

impl Crop {
    /// The pixels from (x₀, y₀) up to (x₁, y₁), which is no longer one of them.
    ///
    /// # Panics
    ///
    /// In debug builds, if x₁ < x₀ or y₁ < y₀: settings are checked before.
    #[must_use]
    pub const fn of_edges([x, y, right, bottom]: [u32; 4]) -> Self {
        Self { x, y, width: right - x, height: bottom - y }
    }

    /// What a file holds whose level 0 is `level`, of a map of `whole` pixels;
    /// `None` if that is the whole map.
    pub(crate) fn of_level(
        level: &Level,
        whole: [u32; 2],
    ) -> std::result::Result<Option<Self>, &'static str> {
        let outside = "its pixels are not those of a map of the size that the metadata state";
        let first = |first: i32| u32::try_from(first).map_err(|_| outside);
        let crop = Self {
            x: first(level.x)?,
            y: first(level.y)?,
            width: level.width,
            height: level.height,
        };
        let axes = [
            (crop.x, crop.width, whole[0], level.tile_width),
            (crop.y, crop.height, whole[1], level.tile_height),
        ];
        for (first, length, whole, tile) in axes {
            let end = first.checked_add(length).filter(|&end| end <= whole).ok_or(outside)?;
            if !first.is_multiple_of(tile) || (end < whole && !end.is_multiple_of(tile)) {
                return Err(
                    "the metadata state another size, and it does not end on a tile's border",
                );
            }
        }
        Ok((crop != Self { x: 0, y: 0, width: whole[0], height: whole[1] }).then_some(crop))
    }

    /// What these pixels say of themselves, as a map of their own: their
    /// window in the whole map's.
    pub(crate) fn metadata(self, whole: &Metadata) -> Result<Metadata> {
        let mut metadata = whole.clone();
        let [width, height] = [self.width, self.height];
        (metadata.width, metadata.height) = (width, height);
        let info = &mut metadata.info;
        let corner = info.data_window.map_or([0, 0], |window| window.min);
        if info.display_window.is_none() {
            // NDC covers the whole map, not the part.
            info.display_window = match info.data_window {
                Some(window) => Some(window),
                None => Some(window(corner, [0, 0], [whole.width, whole.height])?),
            };
        }
        info.data_window = Some(window(corner, [self.x, self.y], [width, height])?);
        Ok(metadata)
    }
}

/// The window of so many pixels that begins `from` the corner.
fn window(corner: [i32; 2], from: [u32; 2], size: [u32; 2]) -> Result<PixelWindow> {
    let axis = |axis: usize| {
        let min = corner[axis].checked_add_unsigned(from[axis])?;
        Some((min, min.checked_add_unsigned(size[axis] - 1)?))
    };
    match (axis(0), axis(1)) {
        (Some((left, right)), Some((top, bottom))) => {
            Ok(PixelWindow { min: [left, top], max: [right, bottom] })
        }
        _ => Err(Error::Metadata("the data window reaches past 2³¹".to_owned())),
    }
}
