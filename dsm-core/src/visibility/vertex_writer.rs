//! Output of a descending polyline, without redundant vertices.

use super::vertex::{SumVertex, Vertex};
use crate::transmittance::Transmittance;

/// Draws a non-increasing function from 1 on, front to back, and emits a
/// vertex only where its value changes.
pub(crate) struct VertexWriter<T: Transmittance, F> {
    sink: F,
    here: f32,
    value: T::Sum,
    /// Depth of the last vertex that was emitted.
    drawn: f32,
}

impl<T: Transmittance, F: FnMut(SumVertex<T>)> VertexWriter<T, F> {
    /// Starts at 1.
    pub(crate) fn new(sink: F) -> Self {
        Self { sink, here: 0.0, value: T::CLEAR.to_sum(), drawn: -1.0 }
    }

    /// Draws a line to `value` at depth `z`: at the depth where the last one
    /// ended, a step. A value that rises stays where it was. Lines come in
    /// ascending z, and at most one step at each.
    #[inline]
    pub(crate) fn line_to(&mut self, z: f32, value: T::Sum) {
        let value = T::sum_from_channels(|channel| {
            value.as_ref()[channel].min(self.value.as_ref()[channel])
        });
        if value != self.value {
            if self.drawn != self.here {
                (self.sink)(Vertex::new(self.here, self.value));
            }
            (self.sink)(Vertex::new(z, value));
            (self.value, self.drawn) = (value, z);
        }
        self.here = z;
    }

    /// The value so far.
    pub(crate) const fn value(&self) -> T::Sum {
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_stretches_and_empty_steps_leave_no_vertex() {
        let mut vertices = Vec::new();
        let mut writer = VertexWriter::<f32, _>::new(|vertex: SumVertex<f32>| {
            vertices.push((vertex.z, vertex.value[0]));
        });
        for (z, value) in [
            (1.0, 1.0),
            (1.0, 1.0),
            (2.0, 1.0),
            (2.0, 0.5),
            (3.0, 0.5),
            (4.0, 0.4),
            (4.0, 0.3),
            (5.0, 0.35),
            (6.0, 0.2),
        ] {
            writer.line_to(z, [value]);
        }
        let expected =
            [(2.0, 1.0), (2.0, 0.5), (3.0, 0.5), (4.0, 0.4), (4.0, 0.3), (5.0, 0.3), (6.0, 0.2)];
        assert_eq!(vertices, expected);
    }
}
