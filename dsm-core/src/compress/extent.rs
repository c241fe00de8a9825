//! How far a path runs above and below the function it stands for.

use crate::transmittance::Transmittance;
use crate::visibility::vertex::{SumVertex, Vertex};

/// The largest differences V′ − V of both signs, in any channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    /// The largest, at least 0.
    pub(super) above: f64,
    /// The least with its sign turned, at least 0.
    pub(super) below: f64,
}

impl Extent {
    /// Between the vertices of V and those of V′: at both sides of every vertex of
    /// either, between which both are linear. In `f64` on the `f32` values. O(n + m).
    pub(super) fn of<T: Transmittance>(vertices: &[SumVertex<T>], path: &[Vertex<T>]) -> Self {
        let mut extent = Self { above: 0.0, below: 0.0 };
        let mut rest = vertices;
        let clear = Vertex::new(0.0, T::CLEAR.to_sum());
        let (mut near, mut from) = (clear, clear);
        let mut corners = path;
        while let Some((before, mut others)) = corners.split_first() {
            let before = Vertex::new(before.z, before.value.to_sum());
            rest = extent.pass::<T>(&from, &before, &mut near, rest);
            from = before;
            if let Some((after, behind)) = others.split_first()
                && after.z <= before.z
            {
                from = Vertex::new(after.z, after.value.to_sum());
                others = behind;
            }
            corners = others;
            // Behind what lies at this depth the next line starts.
            let there = rest.iter().take_while(|vertex| vertex.z <= from.z).count();
            if let Some(last) = there.checked_sub(1) {
                near = rest[last];
                rest = &rest[there..];
            }
            let value = between::<T>(&near, rest.first(), from.z);
            extent.add::<T>(&from.value, &value);
        }
        for vertex in rest {
            extent.add::<T>(&from.value, &vertex.value);
        }
        extent
    }

    /// Compares the line between two places with what lies before its end.
    #[inline(always)]
    fn pass<'a, T: Transmittance>(
        &mut self,
        from: &SumVertex<T>,
        to: &SumVertex<T>,
        near: &mut SumVertex<T>,
        mut rest: &'a [SumVertex<T>],
    ) -> &'a [SumVertex<T>] {
        let length = f64::from(to.z) - f64::from(from.z);
        let per_depth = if length > 0.0 { length.recip() } else { 0.0 };
        let slope = T::sum_from_channels(|channel| {
            (to.value.as_ref()[channel] - from.value.as_ref()[channel]) * per_depth
        });
        let start = f64::from(from.z);
        while let Some((vertex, others)) = rest.split_first() {
            if vertex.z >= to.z {
                break;
            }
            let along = f64::from(vertex.z) - start;
            let value = T::sum_from_channels(|channel| {
                from.value.as_ref()[channel] + slope.as_ref()[channel] * along
            });
            self.add::<T>(&value, &vertex.value);
            *near = *vertex;
            rest = others;
        }
        let value = between::<T>(near, rest.first(), to.z);
        self.add::<T>(&to.value, &value);
        rest
    }

    #[inline(always)]
    fn add<T: Transmittance>(&mut self, path: &T::Sum, value: &T::Sum) {
        for channel in 0..T::CHANNELS {
            let apart = path.as_ref()[channel] - value.as_ref()[channel];
            self.above = if apart > self.above { apart } else { self.above };
            self.below = if -apart > self.below { -apart } else { self.below };
        }
    }
}

/// The value at `z`, not before `near` and not behind `far`, from the light's side.
fn between<T: Transmittance>(near: &SumVertex<T>, far: Option<&SumVertex<T>>, z: f32) -> T::Sum {
    let Some(far) = far else { return near.value };
    let length = f64::from(far.z) - f64::from(near.z);
    let share = if length > 0.0 { (f64::from(z) - f64::from(near.z)) / length } else { 0.0 };
    T::sum_from_channels(|channel| {
        let (from, to) = (near.value.as_ref()[channel], far.value.as_ref()[channel]);
        from + (to - from) * share
    })
}
