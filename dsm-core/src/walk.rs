//! Functions evaluated at ascending depths, one after the other.

use crate::Vertex;
use crate::polyline::Polyline;

/// Combines two values channel by channel.
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
    /// The vertex before the next one.
    previous: Option<Vertex<P::Sum>>,
    next: Option<Vertex<P::Sum>>,
    /// How many vertices lie before `next`.
    passed: usize,
}

impl<'a, P: Polyline + ?Sized> Walk<'a, P> {
    pub(crate) fn new(function: &'a P) -> Self {
        let mut walk = Self { function, previous: None, next: None, passed: 0 };
        walk.next = walk.vertex(0);
        walk
    }

    fn vertex(&self, index: usize) -> Option<Vertex<P::Sum>> {
        (index < self.function.vertex_count()).then(|| self.function.sum_vertex(index))
    }

    pub(crate) fn next_depth(&self) -> Option<f32> {
        self.next.map(|vertex| vertex.z)
    }

    /// The values from the light's side of `z` and at `z`, which is neither
    /// before the last `z` nor behind the next vertex; steps over the
    /// vertices at `z`. None before the first vertex.
    pub(crate) fn advance(&mut self, z: f32) -> Option<[P::Sum; 2]> {
        let before = match (self.previous, self.next) {
            (Some(previous), None) => previous.value,
            (Some(previous), Some(next)) => between(&previous, &next, z),
            (None, Some(next)) if next.z <= z => zip(next.value, next.value, |_, _| 1.0),
            (None, _) => return None,
        };
        let mut at = before;
        while let Some(vertex) = self.next
            && vertex.z <= z
        {
            at = vertex.value;
            self.previous = self.next;
            self.passed += 1;
            self.next = self.vertex(self.passed);
        }
        Some([before, at])
    }

    /// The values just behind `near` and just before `far`, between which
    /// there is no vertex: `near` is where the walk stands. None before the
    /// first vertex.
    pub(crate) fn line(&self, near: f32, far: f32) -> Option<[P::Sum; 2]> {
        let previous = self.previous?;
        let Some(next) = self.next else { return Some([previous.value; 2]) };
        Some([near, far].map(|z| between(&previous, &next, z)))
    }
}

/// The value at `z` on the edge between two vertices.
fn between<S: Copy + AsRef<[f64]> + AsMut<[f64]>>(near: &Vertex<S>, far: &Vertex<S>, z: f32) -> S {
    // Interpolation would round a value near 0 away.
    if z <= near.z {
        return near.value;
    }
    if z >= far.z {
        return far.value;
    }
    let (start, end) = (f64::from(near.z), f64::from(far.z));
    let share = (f64::from(z) - start) / (end - start);
    zip(near.value, far.value, |from, to| from + (to - from) * share)
}
