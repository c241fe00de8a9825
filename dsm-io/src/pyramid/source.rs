//! Where the functions of level 0 come from.

use dsm_core::Transmittance;
use dsm_core::detail::{Polyline, VisibilityView};

use crate::achieved_error::AchievedError;
use crate::error::Result;
use crate::format::encoded_tile::EncodedTile;
use crate::tile::Tile;
use crate::tile_id::TileId;

/// The functions of a tile's pixels, row by row.
pub trait PixelFunctions<T: Transmittance> {
    /// A function, stored or not yet compressed. It satisfies the invariant of
    /// [`VisibilityView`].
    type Function<'a>: Polyline<Sum = T::Sum>
    where
        Self: 'a;

    /// The function of a pixel, counted row by row from the tile's first.
    fn function(&self, pixel: usize) -> Self::Function<'_>;

    /// The largest error that a pixel's function has already, such as that of
    /// the chords of curved stretches. It counts in every level.
    fn error(&self, _pixel: usize) -> f64 {
        0.0
    }
}

impl<T: Transmittance> PixelFunctions<T> for Tile<'_, T> {
    type Function<'a>
        = VisibilityView<'a, T>
    where
        Self: 'a;

    fn function(&self, pixel: usize) -> VisibilityView<'_, T> {
        self.view().function(pixel)
    }
}

/// A tile of level 0.
#[derive(Clone, Debug)]
pub struct SourceTile<F> {
    /// Its functions; none if all are 1 everywhere.
    pub functions: Option<F>,
    /// The tile as it is written, if that is known already. Without, its
    /// functions are compressed under the map's tolerance.
    pub stored: Option<(EncodedTile, AchievedError)>,
}

/// Who gives the functions of level 0, a tile at a time, to any thread.
pub trait PyramidSource<T: Transmittance>: Sync {
    /// The functions of one tile.
    type Functions<'a>: PixelFunctions<T>
    where
        Self: 'a;

    /// Whether it is known at no cost that a tile has no vertices, and no
    /// error. Such tiles are never asked for.
    fn is_clear(&self, _x: u32, _y: u32) -> bool {
        false
    }

    /// How far depths were moved away from the light in any tile at most.
    fn depth_error(&self) -> f32 {
        0.0
    }

    /// The tile of level 0 with this id, which is inside the map.
    ///
    /// # Errors
    ///
    /// Whatever keeps it from being had.
    fn tile(&self, id: TileId) -> Result<SourceTile<Self::Functions<'_>>>;
}
