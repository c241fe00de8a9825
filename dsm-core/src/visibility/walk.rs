//! Functions evaluated at ascending depths, one after the other.

use super::polyline::Polyline;
use super::vertex::Vertex;

/// Combines two values channel by channel.
#[inline(always)]
pub(crate) fn zip<S: Copy + AsRef<[f64]> + AsMut<[f64]>>(
    a: S,
    b: S,
    combine: impl Fn(f64, f64) -> f64,
) -> S {
    let mut combined = a;
    for (channel, &b) in combined.as_mut().iter_mut().zip(b.as_ref()) {
        *channel = combine(*channel, b);
    }
    combined
}

/// A function that is evaluated at ascending depths.
pub(crate) struct Walk<'a, P: Polyline + ?Sized> {
    function: &'a P,
    /// The vertices around the place it has come to; clear before the first.
    previous: Vertex<P::Sum>,
    next: Vertex<P::Sum>,
    /// The depth of `next`, infinite behind the last.
    next_z: f32,
    /// The slope from `previous` to `next`, once it is needed.
    slope: Option<P::Sum>,
    /// Number of vertices before `next`.
    passed: usize,
}

impl<'a, P: Polyline + ?Sized> Walk<'a, P> {
    /// Stands before the first vertex, where the function is `clear`.
    pub(crate) fn new(function: &'a P, clear: P::Sum) -> Self {
        let start = Vertex::new(0.0, clear);
        let slope = Some(zip(clear, clear, |_, _| 0.0));
        let mut walk =
            Self { function, previous: start, next: start, next_z: 0.0, slope, passed: 0 };
        walk.load();
        walk
    }

    #[inline(always)]
    fn load(&mut self) {
        if self.passed < self.function.vertex_count() {
            self.next = self.function.sum_vertex(self.passed);
            self.next_z = self.next.z;
        } else {
            self.next_z = f32::INFINITY;
        }
    }

    /// The depth of the next vertex, infinite behind the last.
    #[inline(always)]
    pub(crate) const fn next_depth(&self) -> f32 {
        self.next_z
    }

    fn slope(&self) -> P::Sum {
        // Flat behind the last vertex, where both are the same.
        let length = f64::from(self.next.z) - f64::from(self.previous.z);
        let per_depth = if length > 0.0 { length.recip() } else { 0.0 };
        zip(self.previous.value, self.next.value, |from, to| (to - from) * per_depth)
    }

    /// The value at `z`, which lies before the next vertex.
    #[inline(always)]
    fn inside(&mut self, z: f32) -> P::Sum {
        let slope = match self.slope {
            Some(slope) => slope,
            None => *self.slope.insert(self.slope()),
        };
        let length = f64::from(z) - f64::from(self.previous.z);
        let value = zip(self.previous.value, slope, |from, slope| from + slope * length);
        // Rounding must not take it below where it falls to.
        zip(value, self.next.value, f64::max)
    }

    /// The values from the light's side of `z` and at `z`, which is neither
    /// before the last `z` nor behind the next vertex; steps over the
    /// vertices at `z`.
    #[inline(always)]
    pub(crate) fn advance(&mut self, z: f32) -> [P::Sum; 2] {
        if z < self.next_z {
            return [self.inside(z); 2];
        }
        let before = if self.passed == 0 { self.previous.value } else { self.next.value };
        while self.next_z <= z {
            self.previous = self.next;
            self.slope = None;
            self.passed += 1;
            self.load();
        }
        [before, self.previous.value]
    }

    /// The values just behind `near` and just before `far`, between which
    /// there is no vertex: `near` is where the walk stands.
    pub(crate) fn line(&mut self, near: f32, far: f32) -> [P::Sum; 2] {
        let start = self.inside(near);
        let end = if far < self.next_z { self.inside(far) } else { self.next.value };
        [start, end]
    }
}
