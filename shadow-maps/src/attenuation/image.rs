//! The layered depth image that views are put into (Agrawala et al. 2000, §4).

use dsm_core::detail::Result;
use dsm_core::{Error, Transmittance};

/// Layers a texel, as they come.
#[derive(Clone, Debug)]
pub(super) struct LayeredImage<T: Transmittance> {
    size: [u32; 2],
    /// The first layer of each texel, [`NONE`] without any.
    first: Vec<u32>,
    layers: Vec<Layer<T>>,
    /// How far a layer reaches to either side, as a share of its w.
    reach: f64,
}

/// A layer of a texel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer<T: Transmittance> {
    /// 1 / depth, of the first hit.
    pub(super) w: f64,
    /// What all views pass to it together, but for the last.
    sum: T::Sum,
    /// What the last view passes to it: at most one count.
    last: T,
    view: u32,
    /// Views that saw it.
    pub(super) views: u32,
    /// The next layer of the texel.
    next: u32,
}

const NONE: u32 = u32::MAX;

impl<T: Transmittance> Layer<T> {
    /// What all views pass to it together.
    pub(super) fn count(&self) -> T::Sum {
        let mut sum = self.sum;
        for (sum, last) in sum.as_mut().iter_mut().zip(self.last.to_sum().as_ref()) {
            *sum += last;
        }
        sum
    }
}

impl<T: Transmittance> LayeredImage<T> {
    /// No layers yet; those of one texel whose w differ by no more than the share `reach`
    /// of it are one.
    pub(super) fn new(size: [u32; 2], reach: f64) -> Self {
        let texels = size[0] as usize * size[1] as usize;
        Self { size, first: vec![NONE; texels], layers: Vec::new(), reach }
    }

    /// Counts what `view` passes to a place of a texel: into the nearest layer within
    /// reach, `lean` times as far on a slope, or a new one. O(layers of the texel).
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 2³² − 1 layers.
    #[inline]
    pub(super) fn insert(
        &mut self,
        [x, y]: [u32; 2],
        (w, lean): (f64, f64),
        passed: T,
        view: u32,
    ) -> Result<()> {
        let texel = y as usize * self.size[0] as usize + x as usize;
        let (mut nearest, mut least) = (NONE, lean * self.reach * w);
        let mut at = self.first[texel];
        while let Some(layer) = self.layers.get(at as usize) {
            let off = (layer.w - w).abs();
            if off < least || off <= least && nearest == NONE {
                (nearest, least) = (at, off);
            }
            at = layer.next;
        }
        if let Some(layer) = self.layers.get_mut(nearest as usize) {
            if layer.view == view {
                let last = layer.last;
                layer.last = T::from_channels(|c| last.channel(c).max(passed.channel(c)));
            } else {
                layer.sum = layer.count();
                (layer.last, layer.view) = (passed, view);
                layer.views += 1;
            }
            return Ok(());
        }
        let (count, limit) = (self.layers.len() as u64, u64::from(NONE));
        if count >= limit {
            return Err(Error::TooLarge { what: "layers", count, limit });
        }
        let (next, sum) = (self.first[texel], T::BLOCKED.to_sum());
        self.first[texel] = count as u32;
        self.layers.push(Layer { w, sum, last: passed, view, views: 1, next });
        Ok(())
    }

    /// The layers of a texel, the nearest first.
    pub(super) fn sorted(&self, texel: usize) -> Vec<Layer<T>> {
        let mut found = Vec::new();
        let mut at = self.first[texel];
        while let Some(layer) = self.layers.get(at as usize) {
            found.push(*layer);
            at = layer.next;
        }
        found.sort_by(|a, b| b.w.total_cmp(&a.w));
        found
    }

    /// Number of layers.
    pub(super) const fn len(&self) -> usize {
        self.layers.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_counts_once_a_layer() {
        let mut image = LayeredImage::<f32>::new([2, 1], 0.01);
        for (w, passed, view) in
            [(0.5, 1.0, 0), (0.5, 1.0, 0), (0.504, 0.25, 1), (0.5, 0.5, 1), (0.52, 1.0, 1)]
        {
            image.insert([1, 0], (w, 1.0), passed, view).unwrap();
        }
        assert!(image.sorted(0).is_empty());
        let found: Vec<_> =
            image.sorted(1).iter().map(|layer| (layer.w, layer.count(), layer.views)).collect();
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].0, found[0].2), (0.52, 1));
        assert_eq!((found[1].0, found[1].2), (0.5, 2));
        assert_eq!(found[1].1.as_ref(), [1.5]);
    }
}
