//! Values of fields and attributes, as far as light depends on them.

use glam::DQuat;

/// A stronger list over a weaker one: USD's list editing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ListOp<T> {
    /// The whole list, if it is not an edit of the weaker one.
    pub(super) explicit: Option<Vec<T>>,
    pub(super) prepended: Vec<T>,
    pub(super) appended: Vec<T>,
    pub(super) deleted: Vec<T>,
}

impl<T> Default for ListOp<T> {
    fn default() -> Self {
        let (prepended, appended, deleted) = (Vec::new(), Vec::new(), Vec::new());
        Self { explicit: None, prepended, appended, deleted }
    }
}

impl<T: Clone + PartialEq> ListOp<T> {
    pub(super) fn of(items: Vec<T>) -> Self {
        Self { explicit: Some(items), ..Self::default() }
    }

    /// Edits `list`, what weaker opinions have made.
    pub(super) fn apply(&self, list: &mut Vec<T>) {
        if let Some(explicit) = &self.explicit {
            list.clone_from(explicit);
        }
        list.retain(|item| {
            ![&self.deleted, &self.prepended, &self.appended].iter().any(|l| l.contains(item))
        });
        list.splice(0..0, self.prepended.iter().cloned());
        list.extend(self.appended.iter().cloned());
    }

    /// Adds what another edit of the same opinion says.
    pub(super) fn join(&mut self, other: Self) {
        self.explicit = other.explicit.or(self.explicit.take());
        self.prepended.extend(other.prepended);
        self.appended.extend(other.appended);
        self.deleted.extend(other.deleted);
    }
}

/// What lies between two values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Between {
    #[default]
    Line,
    /// The earlier one.
    Step,
    /// The shortest turn.
    Arc,
}

/// Numbers, or vectors, quaternions and matrices of them.
///
/// A quaternion is i, j, k, real, as the binary format has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Numbers {
    /// Numbers an element.
    pub(super) size: usize,
    pub(super) is_array: bool,
    pub(super) between: Between,
    pub(super) data: Vec<f64>,
}

impl Numbers {
    /// The value at `part` of the way to `other`.
    pub(super) fn toward(mut self, other: &Self, part: f64) -> Self {
        if self.data.len() != other.data.len() || self.size != other.size {
            return self;
        }
        match self.between {
            Between::Step => {}
            Between::Line => {
                for (from, to) in self.data.iter_mut().zip(&other.data) {
                    *from += (to - *from) * part;
                }
            }
            Between::Arc => {
                let quats = self.data.as_chunks_mut::<4>().0.iter_mut();
                for (from, to) in quats.zip(other.data.as_chunks::<4>().0) {
                    let quat = |quat: &[f64; 4]| DQuat::from_array(*quat).normalize();
                    let turned = quat(from).slerp(quat(to), part);
                    *from = turned.to_array();
                }
            }
        }
        self
    }
}

/// A reference or a payload.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Reference {
    /// Empty for the layer itself.
    pub(super) asset: String,
    /// Empty for the layer's default prim.
    pub(super) path: String,
    pub(super) offset: TimeOffset,
}

/// Time of a layer as time of what refers to it: scale · time + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TimeOffset {
    pub(super) offset: f64,
    pub(super) scale: f64,
}

impl TimeOffset {
    pub(super) const NONE: Self = Self { offset: 0.0, scale: 1.0 };

    /// This one around `inner`.
    pub(super) fn around(self, inner: Self) -> Self {
        let offset = self.offset + self.scale * inner.offset;
        Self { offset, scale: self.scale * inner.scale }
    }

    /// A time outside as one inside.
    pub(super) fn inside(self, time: f64) -> f64 {
        let inside = (time - self.offset) / self.scale;
        if inside.is_finite() { inside } else { time }
    }
}

/// The value of a field.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// No value, whatever weaker opinions say.
    Block,
    Numbers(Numbers),
    /// A token, string, asset path or an array of them.
    Words(Vec<String>),
    Names(ListOp<String>),
    Paths(ListOp<String>),
    Integers(ListOp<i64>),
    References(ListOp<Reference>),
    /// Variants by the names of their sets.
    Selections(Vec<(String, String)>),
    Offsets(Vec<TimeOffset>),
    Samples(Vec<(f64, Stored)>),
    /// Of a kind that no light depends on.
    Other,
}

/// A value as a layer holds it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stored {
    Read(Value),
    /// Where a binary file has it.
    Packed(u64),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_edited() {
        let op = ListOp {
            prepended: vec![3, 9],
            appended: vec![1],
            deleted: vec![2],
            ..ListOp::default()
        };
        let mut list = vec![1, 2, 3, 4];
        op.apply(&mut list);
        assert_eq!(list, [3, 9, 4, 1]);
        ListOp::of(vec![7]).apply(&mut list);
        assert_eq!(list, [7]);
    }

    #[test]
    fn times_nest() {
        let outer = TimeOffset { offset: 10.0, scale: 2.0 };
        let both = outer.around(TimeOffset { offset: 1.0, scale: 0.5 });
        assert_eq!(both, TimeOffset { offset: 12.0, scale: 1.0 });
        assert_eq!(both.inside(15.0), 3.0);
        assert_eq!(TimeOffset { offset: 0.0, scale: 0.0 }.inside(1.0), 1.0);
    }
}
