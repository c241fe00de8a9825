//! How much is measured.

/// Sizes of pictures and maps, and the lights.
#[derive(Clone, Debug, PartialEq)]
pub struct Effort {
    /// Width and height of the pictures, of one shaded point a pixel.
    pub image: [u32; 2],
    /// Light samples a shaded point.
    pub rays: u32,
    /// Pixels along a side of the maps of layers.
    pub map: u32,
    /// Pixels along a side of the maps of fragments, of 8 × 8 places each.
    pub fragment_map: u32,
    /// The light's radius in the tables, in scene units, 5 from what it lights.
    pub radius: f64,
    /// The radii of figure 4, ascending.
    pub radii: Vec<f64>,
    /// Sides of maps of layers whose costs are compared.
    pub maps: Vec<u32>,
    /// The same of maps of fragments.
    pub fragment_maps: Vec<u32>,
}

impl Effort {
    /// Maps as large as the paper's, smaller pictures and fewer rays.
    #[must_use]
    pub fn full() -> Self {
        Self {
            image: [160, 120],
            rays: 64,
            map: 1024,
            fragment_map: 512,
            radius: 0.5,
            radii: vec![0.125, 0.25, 0.5, 1.0],
            maps: vec![512, 1024, 2048, 4096, 8192],
            fragment_maps: vec![128, 256, 512, 1024],
        }
    }

    /// As little as still shows the same.
    #[must_use]
    pub fn small() -> Self {
        Self {
            image: [32, 24],
            rays: 16,
            map: 256,
            fragment_map: 128,
            radius: 0.5,
            radii: vec![0.125, 0.5],
            maps: vec![128, 256],
            fragment_maps: vec![64, 128],
        }
    }
}
