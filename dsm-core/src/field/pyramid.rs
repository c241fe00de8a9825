//! Lookups in a mip pyramid (Lokovic & Veach 2000, §5.3): filters of any
//! width at the cost of a narrow one.

use fearless_simd::{Level as SimdLevel, dispatch};

use super::block::{OneByOne, Runs};
use super::filtered::average;
use super::footprint::Footprint;
use super::receiver::Receiver;
use super::visibility_field::VisibilityField;
use super::weights::Extent;
use crate::error::{Error, Result};
use crate::transmittance::Transmittance;

/// The choice of the level of a [`Pyramid`] that a lookup reads.
///
/// ```
/// use dsm_core::LevelChoice;
///
/// // Half way between the finest level and the next.
/// let blended = LevelChoice::Fixed(0.5);
/// assert_ne!(blended, LevelChoice::FINEST);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelChoice {
    /// This level; between two levels, both are read and their values
    /// interpolated. Below 0 (and NaN) stands for 0, past the last level for
    /// the last.
    Fixed(f64),
    /// The level in which the footprint is 2 to 4 pixels wide: log₂(W / 2) for
    /// a filter W pixels wide in level 0, interpolated between the two levels
    /// around it. Of an ellipse, W is the minor axis, or 1/16 of the major
    /// one if that is more: a thinner ellipse is widened so far, but no more
    /// than the level needs. A point reads level 0.
    Auto,
}

impl LevelChoice {
    /// The finest level, alone.
    pub const FINEST: Self = Self::Fixed(0.0);
}

/// The levels of one map, finest first.
///
/// Pixel (i, j) of level k covers [i · 2ᵏ, (i + 1) · 2ᵏ) × [j · 2ᵏ, (j + 1) · 2ᵏ)
/// of level 0, as far as that lies in the map, and is weighted by the area
/// that does: a last column of which half lies outside has half the weight.
/// The rest has none, as in level 0. A filter's width and an
/// ellipse's axes, the position, and the change of a receiver's depth a pixel
/// are all given in pixels of level 0; in a level in which a filter would be
/// narrower than [`FilterShape::minimum_width`](crate::FilterShape::minimum_width)
/// it is that wide.
///
/// ```
/// use dsm_core::detail::Pyramid;
/// use dsm_core::{
///     DeepMap, Filter, FilterShape, Footprint, LevelChoice, MapInfo,
///     PixelListsBuilder, Receiver, Vertex,
/// };
///
/// // One of four pixels is blocked at depth 1; the mean of all is in level 2.
/// let level = |size, values: &[f32]| {
///     let mut pixels = PixelListsBuilder::new(size, 1);
///     for &value in values {
///         pixels.push(Vertex::new(1.0, 1.0));
///         pixels.push(Vertex::new(1.0, value));
///         pixels.finish_pixel()?;
///     }
///     Ok::<_, dsm_core::Error>(DeepMap::new(MapInfo::default(), pixels.finish()?))
/// };
/// let levels = [level(4, &[0.0, 1.0, 1.0, 1.0])?, level(2, &[0.5, 1.0])?, level(1, &[0.75])?];
/// let pyramid = Pyramid::new(levels.into())?;
///
/// let footprint = Footprint::Isotropic(Filter::new(FilterShape::Box, 8.0)?);
/// let receiver = Receiver::new([2.0, 0.5], 3.0);
/// assert_eq!(pyramid.lookup(&receiver, &footprint, LevelChoice::Auto), Ok(0.75));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Pyramid<F> {
    levels: Vec<F>,
    /// The place of each level.
    places: Vec<Place>,
}

/// The place of a level in the map.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// The side of a pixel of level 0, in its own.
    scale: f32,
    /// The part of it within the map.
    extent: Extent,
}

impl<F: VisibilityField> Pyramid<F> {
    /// The pyramid of these levels, finest first.
    ///
    /// # Errors
    ///
    /// [`Error::Level`] if there is none, or one has not half the width and
    /// height, rounded up, of the level before.
    pub fn new(levels: Vec<F>) -> Result<Self> {
        let sizes: Vec<[u32; 2]> = levels.iter().map(F::size).collect();
        if sizes.is_empty() {
            return Err(Error::Level { level: 0, reason: "there is none" });
        }
        let halved = |pair: &[[u32; 2]]| {
            pair[0] != [1; 2] && pair[1] == pair[0].map(|side| side.div_ceil(2))
        };
        match sizes.windows(2).position(|pair| !halved(pair)) {
            Some(before) => {
                let reason = "its size must be half that of the previous level, rounded up";
                Err(Error::Level { level: before + 1, reason })
            }
            None => {
                // Sides are halved until they are 1: no level is past 2⁻³².
                let place = |level: usize| {
                    let scale = 0.5_f32.powi(level as i32);
                    let extent = sizes[0].map(|side| f64::from(side) * f64::from(scale));
                    Place { scale, extent: Extent(extent) }
                };
                Ok(Self { places: (0..levels.len()).map(place).collect(), levels })
            }
        }
    }

    /// The levels, finest first; at least one.
    #[must_use]
    pub fn levels(&self) -> &[F] {
        &self.levels
    }

    /// The visibility of `receiver`, averaged over `footprint` in the levels of
    /// `choice`.
    ///
    /// In level 0 it is what [`filtered_lookup`](crate::filtered_lookup)
    /// answers. A receiver outside the map, at a depth ≤ 0 or with a NaN is
    /// lit: 1. No allocation. O(p log n) for p pixels of n vertices: with
    /// [`LevelChoice::Auto`], and as long as there is a level for it, a filter
    /// reaches at most 4 × 4 and 2 × 2 pixels in the two levels (of a tent
    /// those are the ones with a weight), an ellipse about 16 times as many.
    ///
    /// # Errors
    ///
    /// The first error of a level.
    pub fn lookup(
        &self,
        receiver: &Receiver,
        footprint: &Footprint,
        choice: LevelChoice,
    ) -> Result<F::Value, F::Error> {
        if !receiver.is_shaded_by(self.places[0].extent) {
            return Ok(F::Value::CLEAR);
        }
        let level = match choice {
            LevelChoice::Fixed(level) => level,
            LevelChoice::Auto => footprint.level(),
        };
        // A NaN becomes 0.
        let level = level.max(0.0).min((self.levels.len() - 1) as f64);
        if F::HAS_RUNS {
            dispatch!(SimdLevel::new(), simd => self.lookup_between(simd, receiver, footprint, level))
        } else {
            self.lookup_between(OneByOne, receiver, footprint, level)
        }
    }

    /// The answer at a level, or between two, to a receiver inside the map.
    #[inline(always)]
    fn lookup_between<R: Runs>(
        &self,
        runs: R,
        receiver: &Receiver,
        footprint: &Footprint,
        level: f64,
    ) -> Result<F::Value, F::Error> {
        let (mut index, share) = (level as usize, level.fract());
        let mut finer: Option<F::Value> = None;
        // A loop, and not two calls: what it holds is large, and compiled for every
        // instruction set.
        loop {
            let light = self.lookup_level(runs, receiver, footprint, index)?;
            match finer {
                None if share == 0.0 => return Ok(light),
                None => (finer, index) = (Some(light), index + 1),
                // Both products are monotone, so their sum is.
                Some(finer) => {
                    return Ok(F::Value::from_channels(|channel| {
                        let fine = f64::from(finer.channel(channel));
                        let coarse = f64::from(light.channel(channel));
                        ((1.0 - share) * fine + share * coarse) as f32
                    }));
                }
            }
        }
    }

    /// The answer of one level to a receiver inside the map.
    #[inline(always)]
    fn lookup_level<R: Runs>(
        &self,
        runs: R,
        receiver: &Receiver,
        footprint: &Footprint,
        level: usize,
    ) -> Result<F::Value, F::Error> {
        let Place { scale, extent } = self.places[level];
        let (receiver, footprint) = (receiver.scaled(scale), footprint.scaled(scale));
        average(runs, &self.levels[level], &receiver, &footprint, extent)
    }
}
