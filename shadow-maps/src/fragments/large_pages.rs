//! Memory for what is read here and there: in large pages where the system has
//! them.

use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable, cast_slice, cast_slice_mut};
use memmap2::MmapMut;

/// Smaller ones gain nothing.
const LARGE: usize = 4 << 20;

/// A fixed number of values.
///
/// A tracer jumps through hundreds of megabytes. In pages of 4 KiB most jumps
/// miss the processor's table of pages, too, which costs as much as the memory
/// itself.
#[derive(Debug)]
pub(crate) enum LargePages<V> {
    Heap(Vec<V>),
    Mapped {
        bytes: MmapMut,
        /// In bytes: a mapping ends with a page.
        size: usize,
    },
}

impl<V: Pod + Zeroable> LargePages<V> {
    /// `count` zeros.
    pub(crate) fn zeroed(count: usize) -> Self {
        Self::mapped(count).unwrap_or_else(|| Self::Heap(vec![V::zeroed(); count]))
    }

    /// `count` zeros, if there is memory for them. What is not written to takes none
    /// on most systems.
    pub(crate) fn try_zeroed(count: usize) -> Option<Self> {
        Self::mapped(count).or_else(|| {
            let mut values = Vec::new();
            values.try_reserve_exact(count).ok()?;
            values.resize(count, V::zeroed());
            Some(Self::Heap(values))
        })
    }

    /// In pages of their own, if they are many.
    fn mapped(count: usize) -> Option<Self> {
        let size = count.checked_mul(size_of::<V>()).filter(|&size| size >= LARGE)?;
        let bytes = MmapMut::map_anon(size).ok()?;
        // What a system cannot do changes nothing but time.
        #[cfg(target_os = "linux")]
        let _ = bytes.advise(memmap2::Advice::HugePage);
        Some(Self::Mapped { bytes, size })
    }
}

impl<V: Pod> Deref for LargePages<V> {
    type Target = [V];

    #[inline(always)]
    fn deref(&self) -> &[V] {
        match self {
            Self::Heap(values) => values,
            Self::Mapped { bytes, size } => cast_slice(&bytes[..*size]),
        }
    }
}

impl<V: Pod> DerefMut for LargePages<V> {
    fn deref_mut(&mut self) -> &mut [V] {
        match self {
            Self::Heap(values) => values,
            Self::Mapped { bytes, size } => cast_slice_mut(&mut bytes[..*size]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_ones_hold_what_is_written() {
        for count in [0, 3, LARGE / 4 - 1, LARGE / 4 + 1] {
            let mut values = LargePages::<u32>::zeroed(count);
            assert_eq!(matches!(values, LargePages::Mapped { .. }), 4 * count >= LARGE);
            assert_eq!(values.len(), count);
            assert!(values.iter().all(|&value| value == 0));
            (0..).zip(values.iter_mut()).for_each(|(index, value)| *value = index);
            assert!((0..).zip(values.iter()).all(|(index, &value)| value == index));
        }
    }
}
