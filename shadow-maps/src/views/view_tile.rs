//! A tile of a depth image.

use dsm_io::detail::MapTile;

/// The w = 1/depth of the pixels of a tile, 0 where nothing is.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewTile {
    pub(super) size: [u32; 2],
    pub(super) w: Vec<f32>,
}

impl ViewTile {
    /// Pixels that see nothing.
    #[must_use]
    pub fn empty(size: [u32; 2]) -> Self {
        Self { size, w: vec![0.0; size[0] as usize * size[1] as usize] }
    }

    /// Pixels with these w, row by row. None unless there is one a pixel.
    #[must_use]
    pub fn new(size: [u32; 2], w: Vec<f32>) -> Option<Self> {
        (w.len() as u64 == u64::from(size[0]) * u64::from(size[1])).then_some(Self { size, w })
    }

    /// w of all pixels, row by row.
    #[must_use]
    pub fn w(&self) -> &[f32] {
        &self.w
    }

    /// Number of pixels that see something, and between which depths.
    pub(super) fn seen(&self) -> (u64, [f32; 2]) {
        let seen = self.w.iter().filter(|&&w| w > 0.0);
        let ends = seen
            .clone()
            .fold([f32::INFINITY, 0.0_f32], |[low, high], &w| [low.min(w), high.max(w)]);
        let depth = |w: f32| w.recip().min(f32::MAX);
        (seen.count() as u64, [depth(ends[1]), depth(ends[0])])
    }
}

impl MapTile for ViewTile {
    #[inline]
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn bytes(&self) -> u64 {
        size_of_val(&self.w[..]) as u64
    }
}
