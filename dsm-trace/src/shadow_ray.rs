//! Shadow rays in the frame of a light.

/// A straight line in (raster x, raster y, w = 1/depth), from the receiver
/// towards the light: w grows along it. It holds the points with w in
/// [start, end).
///
/// ```
/// use dsm_trace::ShadowRay;
///
/// // From pixel position (1, 1) at depth 1/0.25, 8 pixels to the right per unit of w.
/// let ray = ShadowRay::new([1.0, 1.0], 0.25, [8.0, 0.0], 0.5);
/// assert_eq!(ray.at(0.375), [2.0, 1.0]);
/// assert_eq!(ray.crossing([1, 0], [2, 2]), Some([0.25, 0.375]));
/// assert_eq!(ray.crossing([1, 2], [2, 3]), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowRay {
    place: [f64; 2],
    /// w at `place`.
    origin: f64,
    slope: [f64; 2],
    start: f64,
    end: f64,
}

/// The part of a ray within a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayClip {
    /// The ray within the raster and the map's depths; `None` if it has no
    /// point there.
    pub ray: Option<ShadowRay>,
    /// True if the ray is outside the raster somewhere at the map's depths:
    /// occluders there are unknown, and taken for none.
    pub leaves: bool,
}

impl ShadowRay {
    /// The ray that starts at `place` in pixels at depth 1/`w`, moves by
    /// `slope` pixels per unit of w, and ends where w is `end`, which is not
    /// part of it.
    #[must_use]
    pub const fn new(place: [f64; 2], w: f64, slope: [f64; 2], end: f64) -> Self {
        Self { place, origin: w, slope, start: w, end }
    }

    /// True if its numbers are finite; the end may be infinite.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let [x, y] = self.place;
        let [along_x, along_y] = self.slope;
        [x, y, along_x, along_y, self.origin, self.start].iter().all(|value| value.is_finite())
            && !self.end.is_nan()
    }

    /// First and last w, half-open.
    #[must_use]
    pub const fn range(&self) -> [f64; 2] {
        [self.start, self.end]
    }

    /// Pixels per unit of w.
    #[must_use]
    pub const fn slope(&self) -> [f64; 2] {
        self.slope
    }

    /// The raster position of the ray at `w`.
    #[must_use]
    pub fn at(&self, w: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.place[axis] + self.slope[axis] * (w - self.origin))
    }

    /// w over the pixels `low` to `high` (half-open) of an axis: [in, out),
    /// clipped to the ray; empty where in ≥ out.
    ///
    /// Each border is crossed at one w, whoever asks: the intervals of
    /// neighbours abut, and those of a block hold those of its parts. A ray
    /// along a border is in the pixel that begins there.
    fn within(&self, axis: usize, low: f64, high: f64) -> [f64; 2] {
        let (place, slope) = (self.place[axis], self.slope[axis]);
        let crossing = |border: f64| self.origin + (border - place) / slope;
        if slope > 0.0 {
            [crossing(low).max(self.start), crossing(high).min(self.end)]
        } else if slope < 0.0 {
            [crossing(high).max(self.start), crossing(low).min(self.end)]
        } else if low <= place && place < high {
            [self.start, self.end]
        } else {
            [self.end, self.start]
        }
    }

    /// w where the ray enters the block of pixels from `min` to `max`
    /// (half-open), and where it leaves it; `None` if it does not cross it.
    #[must_use]
    pub fn crossing(&self, min: [u32; 2], max: [u32; 2]) -> Option<[f64; 2]> {
        let [x_in, x_out] = self.within(0, min[0].into(), max[0].into());
        let [y_in, y_out] = self.within(1, min[1].into(), max[1].into());
        let (enter, leave) = (x_in.max(y_in), x_out.min(y_out));
        (enter < leave).then_some([enter, leave])
    }

    /// The part of the ray with w in a range, half-open.
    #[inline]
    #[must_use]
    pub const fn between(&self, [start, end]: [f64; 2]) -> Self {
        Self { start: self.start.max(start), end: self.end.min(end), ..*self }
    }

    /// The part of the ray within a raster of `size` pixels and the depths
    /// 1/`range` of a map, both ends included (Xie et al. 2007, §4.3).
    #[must_use]
    pub fn clip(&self, size: [u32; 2], range: [f32; 2]) -> RayClip {
        let [low, high] = range.map(f64::from);
        let deep = Self {
            start: self.start.max(low),
            // Layers at `high` itself are the ray's, unless it ends there.
            end: self.end.min(high.next_up()),
            ..*self
        };
        let empty = range.iter().any(|w| w.is_nan()) || deep.start >= deep.end;
        if empty || !deep.is_sound() {
            return RayClip { ray: None, leaves: false };
        }
        match deep.crossing([0; 2], size) {
            None => RayClip { ray: None, leaves: true },
            Some([start, end]) => RayClip {
                ray: Some(Self { start, end, ..deep }),
                leaves: start > deep.start || end < deep.end,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_share_no_point_and_lose_none() {
        for slope in [[3.0, 0.0], [-3.0, 0.5], [0.1, -7.0], [0.0, 0.0]] {
            let ray = ShadowRay::new([2.0, 1.5], 0.25, slope, 1.25);
            let mut at = 0.25;
            let mut crossed = Vec::new();
            for (x, y) in (0..4).flat_map(|x| (0..4).map(move |y| (x, y))) {
                crossed.extend(ray.crossing([x, y], [x + 1, y + 1]));
            }
            crossed.sort_by(|a, b| a[0].total_cmp(&b[0]));
            for [enter, leave] in &crossed {
                assert_eq!(*enter, at);
                at = *leave;
            }
            assert_eq!(Some(at), ray.crossing([0, 0], [4, 4]).map(|[_, leave]| leave));
        }
    }

    #[test]
    fn clips_to_the_raster_and_to_the_depths() {
        let ray = ShadowRay::new([2.0, 2.0], 0.25, [4.0, 0.0], 2.0);
        let inside = ray.clip([4, 4], [0.25, 0.5]);
        assert!(!inside.leaves);
        let range = inside.ray.unwrap().range();
        assert_eq!(range, [0.25, 0.5_f64.next_up()]);
        let out = ray.clip([4, 4], [0.25, 1.0]);
        assert!(out.leaves);
        assert_eq!(out.ray.unwrap().range(), [0.25, 0.75]);
        assert_eq!(ray.clip([4, 4], [0.1, 0.2]), RayClip { ray: None, leaves: false });
        assert_eq!(ray.clip([1, 4], [0.25, 0.5]), RayClip { ray: None, leaves: true });
        assert_eq!(ray.clip([4, 4], [f32::NAN; 2]), RayClip { ray: None, leaves: false });
        // The light's own depth is not the ray's.
        assert_eq!(ray.clip([40, 4], [2.0, 3.0]).ray, None);
    }
}
