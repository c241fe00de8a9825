//! What a stored map holds.

/// What the tiles of a layered map hold together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayeredSummary {
    /// Runs of all pixels; of a map without runs, pixels with layers.
    pub runs: u64,
    /// The most runs of a pixel.
    pub most_runs: u64,
    /// Layers of all pixels.
    pub layers: u64,
    /// The most layers of a pixel.
    pub most_layers: u64,
    /// The samples that all layers count.
    pub samples: u64,
    /// Pixels without a layer.
    pub empty_pixels: u64,
}

impl LayeredSummary {
    /// Counts a pixel in.
    pub(super) fn add(&mut self, runs: u64, layers: u64) {
        self.runs += runs;
        self.most_runs = self.most_runs.max(runs);
        self.layers += layers;
        self.most_layers = self.most_layers.max(layers);
        self.empty_pixels += u64::from(layers == 0);
    }
}
