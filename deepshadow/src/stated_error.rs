//! The errors that a map states.

use dsm_core::detail::largest_fall;
use dsm_core::{DeepMap, Transmittance};
use dsm_io::AchievedError;
use dsm_io::detail::AnyDeepMap;
use rayon::prelude::*;

use crate::error::Result;
use crate::shadow_map::ShadowMap;

/// The error that a level of a map states, of visibility functions against what they
/// stand for.
///
/// Codec `quantized` moves depths away from the light by up to δ ([`Self::depth`]).
/// [`Self::max`] is the error beside that: V(z) − ε ≤ V′(z) ≤ V(z − δ) + ε for ε the
/// maximum. Who compares two functions at one and the same depth finds up to
/// [`Self::at_depth`].
///
/// ```no_run
/// let map = deepshadow::ShadowMap::open("hair.dsm")?;
/// let stated = map.stated_errors()?[0];
/// println!("{} at any depth, {} within {}", stated.at_depth, stated.max, stated.depth);
/// # Ok::<(), deepshadow::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StatedError {
    /// The bound that every function keeps beside δ, in [0, 1).
    pub tolerance: f32,
    /// The largest error of any function beside δ, in [0, 1].
    pub max: f32,
    /// The mean of the functions' mean errors, beside δ.
    pub mean: f32,
    /// δ, the largest shift of a depth away from the light, in scene units; 0 where
    /// depths are exact.
    pub depth: f32,
    /// A bound of the error at any one depth, shifts counted, in [0, 1]: [`Self::max`]
    /// and, tile by tile, the largest fall of a function within δ.
    pub at_depth: f32,
}

impl ShadowMap {
    /// The errors that the levels state, finest first. Reads the directories, and the
    /// tiles whose depths were moved: O(vertices) of those, a tile a thread in memory.
    ///
    /// # Errors
    ///
    /// [`Error::File`](crate::Error::File) for a damaged directory or tile.
    pub fn stated_errors(&self) -> Result<Vec<StatedError>> {
        (0..).zip(self.levels()).map(|(index, _)| self.stated_error(index)).collect()
    }

    fn stated_error(&self, index: u32) -> Result<StatedError> {
        let (container, level) = (self.container(), &self.levels()[index as usize]);
        let moved: Vec<_> = container
            .directory(index)?
            .iter()
            .filter(|(_, tile)| tile.depth_error > 0.0)
            .filter_map(|(id, tile)| Some((level.tile_rect(id.x, id.y)?, *tile)))
            .collect();
        let errors = moved.par_iter().map(|(rect, tile)| -> Result<(f32, f32)> {
            let fall = match self.functions(index, *rect)? {
                Some(AnyDeepMap::Mono(map)) => fall_of_any(&map, tile.depth_error),
                Some(AnyDeepMap::Rgb(map)) => fall_of_any(&map, tile.depth_error),
                // No functions: nothing is known of what lies within δ.
                None => 1.0,
            };
            let bound = f64::from(tile.error.max) + fall;
            Ok((tile.depth_error, AchievedError::enclosing(bound, 0.0).max))
        });
        let largest = |a: (f32, f32), b: (f32, f32)| (a.0.max(b.0), a.1.max(b.1));
        let (depth, beside) = errors.try_reduce(|| (0.0, 0.0), |a, b| Ok(largest(a, b)))?;
        Ok(StatedError {
            tolerance: level.tolerance,
            max: level.error.max,
            mean: level.error.mean,
            depth,
            at_depth: level.error.max.max(beside),
        })
    }
}

/// The largest fall of any pixel's function over a distance in depth.
fn fall_of_any<T: Transmittance>(map: &DeepMap<T>, distance: f32) -> f64 {
    let functions = map.pixels().view().functions();
    functions.map(|function| largest_fall(&function, distance)).fold(0.0, f64::max)
}
