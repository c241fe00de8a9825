//! Lookups of the light that reaches a point (Selgrad et al. 2014, §5).

use dsm_core::Transmittance;

use super::accumulate::Accumulate;
use super::hat::Hat;
use super::level_plan::LevelGeometry;
use super::list_sum::Window;
use super::sums::ListView;

/// The lists of all levels, wherever they are.
pub trait LevelLists<T: Transmittance> {
    /// The error of reading a list; `Infallible` in memory.
    type Error;

    /// Calls `look` with the list of a texel that the level has.
    ///
    /// # Errors
    ///
    /// What it cannot be read for.
    fn with_list<R>(
        &self,
        level: usize,
        texel: [u32; 2],
        look: impl FnOnce(ListView<'_, T>) -> R,
    ) -> Result<R, Self::Error>;
}

/// The largest w of what a directory states to begin at a depth: depths are rounded.
pub(super) fn nearest_of(depth: f32) -> f64 {
    f64::from(depth).recip() * (1.0 + 1e-6)
}

/// What is known of a map's levels beside their lists.
#[derive(Clone, Debug)]
pub struct Levels {
    pub(super) geometry: Vec<LevelGeometry>,
    /// The filter that a lookup has in each, in texels of level 0: they rise.
    sizes: Vec<f64>,
    /// The largest w of each; less than any if there is none.
    nearest: Vec<f64>,
}

/// The receiver's plane, which fragments of its own surface lie in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReceiverPlane {
    /// By how much w grows per texel of level 0.
    pub(super) slope: [f64; 2],
    /// By how much w of what counts lies above the plane; below 0 where the surface
    /// shades the receiver itself.
    pub(super) offset: f64,
    /// Whether what counts is nearer to the light than the receiver, too.
    pub(super) is_lit: bool,
}

/// A light, or a part of one, as a receiver sees it in the frame of the map, where
/// shadow rays are straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightCone {
    /// The receiver's raster position and w.
    pub(super) place: [f64; 2],
    pub(super) w: f64,
    /// What counts has a larger w than this.
    pub(super) start: f64,
    /// And than this, whatever plane there is: what is nearer is somebody else's.
    pub(super) least: f64,
    /// How the ray to the light's centre moves per unit of w.
    pub(super) slope: [f64; 2],
    /// How the light's width, as the filter's, grows per unit of w; 0 for a point.
    pub(super) rate: f64,
    pub(super) plane: Option<ReceiverPlane>,
}

/// Levels of a map of 2²⁴ texels a side.
pub(super) const MOST_LEVELS: usize = 25;

/// Less light than this is none: coarse levels may end a lookup.
const LEAST: f32 = 1e-3;

/// A texel beside a place, and its share in an interpolation.
struct Corner {
    level: usize,
    texel: [u32; 2],
    share: f64,
    window: Window,
}

impl Levels {
    /// Levels that stand so, and the largest w of each.
    pub(super) fn new(geometry: Vec<LevelGeometry>, nearest: Vec<f64>) -> Self {
        let sizes = geometry.iter().map(LevelGeometry::filter_size).collect();
        Self { geometry, sizes, nearest }
    }

    /// The fraction of light that is left, of each channel.
    ///
    /// # Errors
    ///
    /// What a list cannot be read for.
    pub(super) fn visibility<T: Transmittance, L: LevelLists<T>>(
        &self,
        lists: &L,
        cone: &LightCone,
        accumulate: Accumulate,
    ) -> Result<T, L::Error> {
        if cone.rate.is_nan() || cone.rate <= 0.0 {
            return self.point(lists, cone, accumulate);
        }
        match accumulate {
            Accumulate::Multiply => self.product(lists, cone),
            Accumulate::Add => self.sum(lists, cone),
            Accumulate::Max => self.largest(lists, cone),
        }
    }

    /// True if no list of level 0 within `radius` texels of a receiver has a fragment
    /// between where it begins to count, or `behind` if that is told, and where the
    /// receiver's rays end ([`LightCone::least`]).
    ///
    /// # Errors
    ///
    /// What a list cannot be read for.
    pub(super) fn is_clear<T: Transmittance, L: LevelLists<T>>(
        &self,
        lists: &L,
        cone: &LightCone,
        radius: f64,
        behind: Option<f64>,
    ) -> Result<bool, L::Error> {
        let size = self.geometry[0].size;
        let (place, high) = (cone.place, cone.least);
        let near = LightCone { least: 0.0, ..*cone };
        // Nothing lies outside; casts saturate.
        let range = |axis: usize| {
            let [first, last] = [-radius, radius].map(|off| (place[axis] + off).floor());
            first.max(0.0) as u32..(last.max(-1.0) + 1.0).min(f64::from(size[axis])) as u32
        };
        for y in range(1) {
            for x in range(0) {
                let centre = [x, y].map(|index| f64::from(index) + 0.5);
                let low = behind.unwrap_or_else(|| near.start_at(centre));
                let is_clear = lists.with_list(0, [x, y], |list| {
                    list.w.iter().all(|&w| f64::from(w) <= low || f64::from(w) > high)
                })?;
                if !is_clear {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// What a point light leaves of the texel that holds the receiver.
    fn point<T: Transmittance, L: LevelLists<T>>(
        &self,
        lists: &L,
        cone: &LightCone,
        accumulate: Accumulate,
    ) -> Result<T, L::Error> {
        let texel = cone.place.map(f64::floor);
        let size = self.geometry[0].size;
        let is_inside = (0..2).all(|axis| (0.0..f64::from(size[axis])).contains(&texel[axis]));
        if !is_inside {
            return Ok(T::CLEAR);
        }
        let centre = texel.map(|index| index + 0.5);
        let start = cone.start_at(centre);
        lists.with_list(0, texel.map(|index| index as u32), |list| {
            let count = list.w.iter().filter(|&&w| f64::from(w) > start).count();
            let taken = accumulate.of(list.opacities[..count].iter().copied());
            T::from_channels(|channel| 1.0 - taken.channel(channel))
        })
    }

    /// The product of what all levels leave, coarse ones first: often little else is
    /// read.
    fn product<T: Transmittance, L: LevelLists<T>>(
        &self,
        lists: &L,
        cone: &LightCone,
    ) -> Result<T, L::Error> {
        let mut room = [0.0; MOST_LEVELS];
        let places = cone.places(&self.sizes, &mut room);
        let mut left = T::CLEAR;
        for level in (0..places.len()).rev() {
            let Some(window) = self.window(level, places, cone) else { continue };
            let mut mean = T::BLOCKED;
            let mut clear = 1.0_f32;
            for corner in self.corners(level, places[level], window, cone).into_iter().flatten() {
                let share = corner.share as f32;
                let own: T =
                    lists.with_list(level, corner.texel, |list| corner.window.product(&list))?;
                clear -= share;
                mean = T::from_channels(|c| mean.channel(c) + share * own.channel(c));
            }
            // Outside the level nothing is in the way.
            let clear = clear.max(0.0);
            left = T::from_channels(|c| left.channel(c) * (mean.channel(c) + clear).min(1.0));
            if (0..T::CHANNELS).all(|channel| left.channel(channel) < LEAST) {
                break;
            }
        }
        Ok(sound(left))
    }

    /// One less the sum of what all fragments take.
    fn sum<T: Transmittance, L: LevelLists<T>>(
        &self,
        lists: &L,
        cone: &LightCone,
    ) -> Result<T, L::Error> {
        let mut taken = T::BLOCKED.to_sum();
        self.each_corner(cone, |corner| {
            let sum: T::Sum =
                lists.with_list(corner.level, corner.texel, |list| corner.window.sum(&list))?;
            add(&mut taken, &sum, corner.share);
            Ok(())
        })?;
        Ok(remains(taken))
    }

    /// One less the largest of what is taken between the places of two levels.
    fn largest<T: Transmittance, L: LevelLists<T>>(
        &self,
        lists: &L,
        cone: &LightCone,
    ) -> Result<T, L::Error> {
        // Between two levels both have the same fragments, with weights that sum to 1.
        let mut between = vec![T::BLOCKED.to_sum(); self.sizes.len() + 1];
        self.each_corner(cone, |corner| {
            let sides: [T::Sum; 2] =
                lists.with_list(corner.level, corner.texel, |list| corner.window.largest(&list))?;
            for (side, most) in sides.iter().enumerate() {
                add(&mut between[corner.level + side], most, corner.share);
            }
            Ok(())
        })?;
        let mut taken = T::BLOCKED.to_sum();
        for most in &between {
            let channels = taken.as_mut().iter_mut().zip(most.as_ref());
            channels.for_each(|(taken, most)| *taken = taken.max(*most));
        }
        Ok(remains(taken))
    }

    /// Calls `visit` for every texel that a lookup reads.
    fn each_corner<E>(
        &self,
        cone: &LightCone,
        mut visit: impl FnMut(&Corner) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut room = [0.0; MOST_LEVELS];
        let places = cone.places(&self.sizes, &mut room);
        for level in 0..places.len() {
            let Some(window) = self.window(level, places, cone) else { continue };
            let corners = self.corners(level, places[level], window, cone);
            corners.iter().flatten().try_for_each(&mut visit)?;
        }
        Ok(())
    }

    /// Which fragments of a level count; `None` if none can.
    #[inline]
    fn window(&self, level: usize, places: &[f64], cone: &LightCone) -> Option<Window> {
        let hat = Hat::of_places(places, level);
        let start = if cone.plane.is_some() { hat.knots[0] } else { cone.start };
        let window = Window::new(hat, start.max(cone.least));
        (!window.is_beyond(self.nearest[level])).then_some(window)
    }

    /// The four texels around the ray where it is at `w`.
    #[inline]
    fn corners(
        &self,
        level: usize,
        w: f64,
        window: Window,
        cone: &LightCone,
    ) -> [Option<Corner>; 4] {
        let geometry = &self.geometry[level];
        // Places of coarse levels may lie beyond all fragments, and beyond the light.
        let along = w.min(self.nearest[level].max(cone.w)) - cone.w;
        let place = [0, 1].map(|axis| cone.place[axis] + cone.slope[axis] * along);
        let at = geometry.texel(place);
        let first = at.map(f64::floor);
        let share = [at[0] - first[0], at[1] - first[1]];
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|step| {
            let texel = [first[0] + step[0], first[1] + step[1]];
            let of = |axis: usize| {
                if step[axis] > 0.0 { share[axis] } else { 1.0 - share[axis] }
            };
            let share = of(0) * of(1);
            let size = geometry.size;
            let is_inside =
                (0..2).all(|axis| texel[axis] >= 0.0 && texel[axis] < f64::from(size[axis]));
            if !is_inside || share <= 0.0 {
                return None;
            }
            let window = match cone.plane {
                Some(_) => window.above(cone.start_at(geometry.centre(texel))),
                None => window,
            };
            if window.is_beyond(self.nearest[level]) {
                return None;
            }
            Some(Corner { level, texel: texel.map(|index| index as u32), share, window })
        })
    }
}

impl LightCone {
    /// Where the light's cone is as wide as each filter.
    #[inline]
    fn places<'a>(&self, sizes: &[f64], room: &'a mut [f64; MOST_LEVELS]) -> &'a [f64] {
        let places = room.iter_mut().zip(sizes);
        let count = places.map(|(place, size)| *place = self.w + size / self.rate).count();
        &room[..count]
    }

    /// Where fragments begin to count at a place of level 0.
    #[inline]
    fn start_at(&self, place: [f64; 2]) -> f64 {
        let Some(plane) = self.plane else { return self.start.max(self.least) };
        let across = [0, 1].map(|axis| plane.slope[axis] * (place[axis] - self.place[axis]));
        let on_plane = self.w + across[0] + across[1] + plane.offset;
        let start = if plane.is_lit { on_plane.max(self.start) } else { on_plane };
        start.max(self.least)
    }
}

fn add<S: AsRef<[f64]> + AsMut<[f64]>>(to: &mut S, from: &S, share: f64) {
    for (to, from) in to.as_mut().iter_mut().zip(from.as_ref()) {
        *to += share * from;
    }
}

/// What is left of the light where this is taken.
fn remains<T: Transmittance>(taken: T::Sum) -> T {
    sound(T::from_channels(|channel| 1.0 - taken.as_ref()[channel].min(1.0) as f32))
}

/// A transmittance in [0, 1]; sums that overflowed leave all of the light.
fn sound<T: Transmittance>(left: T) -> T {
    T::from_channels(|channel| {
        let left = left.channel(channel);
        if left.is_nan() { 1.0 } else { left.clamp(0.0, 1.0) }
    })
}
