//! The runs of layers of a pixel's rays (Xie, Tabellion & Pearce
//! 2007, §5.1).

use dsm_core::detail::{
    Compressor, SampledPixel, SumVertex, TransmittanceBuilder, TransmittanceFunction,
    VisibilityDifference, VisibilitySweep,
};
use dsm_core::{Compression, CompressionMethod, RayHits, Tolerance, Transmittance, Vertex};

use crate::layer::Layer;
use crate::multilayer_settings::MultilayerSettings;

/// The share of ε under which light counts as none, so that a run ends: the rest
/// is for chords and compression.
const ENDS_BELOW: f64 = 1.0 / 8.0;

/// Builds the runs of one pixel after the other, and keeps its memory in
/// between.
#[derive(Debug)]
pub(crate) struct RunBuilder<T: Transmittance> {
    tolerance: Tolerance,
    resets: u32,
    max_layers: u32,
    light_depth: f32,
    chord_error: f64,
    builder: TransmittanceBuilder<T>,
    sweep: VisibilitySweep<T>,
    /// What lies behind the runs so far.
    rays: Vec<RayHits<T>>,
    functions: Vec<TransmittanceFunction<T>>,
    exact: Vec<SumVertex<T>>,
    /// Where the samples of the run lie.
    depths: Vec<f32>,
    layers: Vec<Layer<T>>,
    /// Where each run of the pixel ends in `layers`.
    ends: Vec<usize>,
}

/// The runs of a pixel, and how well they fit.
#[derive(Debug)]
pub(crate) struct PixelRuns<'a, T> {
    layers: &'a [Layer<T>],
    ends: &'a [usize],
    pub(crate) max_error: f64,
    pub(crate) mean_error: f64,
    /// Whether layers were left out because there were too many.
    pub(crate) is_cut: bool,
    /// How much light those of the run that was cut would have stopped, of what arrives
    /// where the run starts: the channel where that is most.
    pub(crate) gained: f64,
}

impl<'a, T> PixelRuns<'a, T> {
    pub(crate) fn runs(&self) -> impl Iterator<Item = &'a [Layer<T>]> {
        let layers = self.layers;
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(self.ends).map(move |(start, &end)| &layers[start..end])
    }
}

/// How far a run reaches.
struct Reach {
    /// The depth at which no light is left; none: it is the last run.
    end: Option<f32>,
    /// What light was left there after all.
    lost: f64,
    /// Whether chords stand for exponentials.
    is_curved: bool,
}

impl<T: Transmittance> RunBuilder<T> {
    pub(crate) fn new(settings: &MultilayerSettings) -> Self {
        let tolerance = settings.tolerance();
        let chord_error = tolerance.chord();
        Self {
            tolerance,
            resets: settings.resets,
            max_layers: settings.max_layers,
            light_depth: settings.light_depth,
            chord_error,
            builder: TransmittanceBuilder::new(chord_error),
            sweep: VisibilitySweep::default(),
            rays: Vec::new(),
            functions: Vec::new(),
            exact: Vec::new(),
            depths: Vec::new(),
            layers: Vec::new(),
            ends: Vec::new(),
        }
    }

    /// The runs of a pixel.
    pub(crate) fn build(&mut self, pixel: &SampledPixel<'_, T>) -> PixelRuns<'_, T> {
        self.layers.clear();
        self.ends.clear();
        let (mut max_error, mut errors, mut falls) = (0.0_f64, 0.0, 0);
        let (mut is_cut, mut gained) = (false, 0.0);
        let mut start = (self.light_depth > 0.0).then_some(self.light_depth);
        for _ in 0..=self.resets {
            let first = self.layers.len();
            let reach = self.sum_up(pixel, start);
            let chord_error = if reach.is_curved { self.chord_error } else { 0.0 };
            let spent = chord_error + reach.lost;
            self.compress(self.tolerance.after(spent));
            if self.layers.len() == first {
                break;
            }
            let difference = self.difference(first);
            max_error = max_error.max(difference.max() + spent);
            errors += difference.mean() + spent;
            self.count(first);
            (is_cut, gained) = self.cut(first, &mut falls);
            if self.layers.len() > first {
                self.ends.push(self.layers.len());
            }
            start = reach.end;
            if start.is_none() || is_cut {
                break;
            }
        }
        let mean_error = (errors / self.ends.len().max(1) as f64).min(max_error);
        let (layers, ends) = (&self.layers, &self.ends);
        PixelRuns { layers, ends, max_error, mean_error, is_cut, gained }
    }

    /// Makes the function of what lies behind `start`, up to where no light is
    /// left, and notes where its samples lie.
    fn sum_up(&mut self, pixel: &SampledPixel<'_, T>, start: Option<f32>) -> Reach {
        self.exact.clear();
        self.depths.clear();
        let count = pixel.rays().len();
        self.functions.resize_with(count, TransmittanceFunction::default);
        if let Some(start) = start {
            self.rays.resize_with(count, RayHits::default);
            for (ray, met) in self.rays.iter_mut().zip(pixel.rays()) {
                ray.clone_from(met);
                ray.keep_behind(start);
            }
        }
        let rays = if start.is_some() { &self.rays[..count] } else { pixel.rays() };
        for (function, ray) in self.functions.iter_mut().zip(rays) {
            self.builder.build(ray, function);
        }
        let functions: Vec<_> = pixel.weights().iter().copied().zip(&self.functions).collect();
        let sum = self.sweep.over(&functions);
        let is_curved = sum.is_curved();
        sum.run(|vertex| self.exact.push(vertex));
        let (end, lost) = self.end_where_no_light_is_left();
        let reached = end.unwrap_or(f32::INFINITY);
        for function in pixel.weights().iter().zip(&self.functions) {
            if *function.0 > 0.0 {
                let pairs = function.1.vertices().windows(2);
                let falls = pairs.filter(|pair| pair[0].value != pair[1].value);
                self.depths.extend(falls.map(|pair| pair[1].z).take_while(|&z| z <= reached));
            }
        }
        self.depths.sort_by(f32::total_cmp);
        Reach { end, lost, is_curved }
    }

    /// Ends the function at exactly 0 where hardly any light is left, if it
    /// falls that far; where, and how much was.
    fn end_where_no_light_is_left(&mut self) -> (Option<f32>, f64) {
        let threshold = ENDS_BELOW * f64::from(self.tolerance.epsilon());
        let most = |vertex: &SumVertex<T>| {
            vertex.value.as_ref().iter().fold(0.0_f64, |most, &value| most.max(value))
        };
        let dark = self.exact.partition_point(|vertex| most(vertex) > threshold);
        let Some(vertex) = self.exact.get_mut(dark) else { return (None, 0.0) };
        let (end, lost) = (vertex.z, most(vertex));
        vertex.value = T::BLOCKED.to_sum();
        self.exact.truncate(dark + 1);
        (Some(end), lost)
    }

    /// Compresses the run, without counts.
    fn compress(&mut self, tolerance: Tolerance) {
        let layers = &mut self.layers;
        let mut emit = |vertex: Vertex<T>| {
            layers.push(Layer { depth: vertex.z, visibility: vertex.value, count: 0 });
        };
        // Layers stand at depths of samples.
        let greedy = Compression::new(CompressionMethod::Greedy);
        greedy.compressor().compress(tolerance, &self.exact, &mut emit);
    }

    /// Gives every sample of the run to the layer that ends with it: at the
    /// sample's depth the layer that falls there, or else the next behind it.
    fn count(&mut self, first: usize) {
        let run = &mut self.layers[first..];
        let last = run.len() - 1;
        let mut at = 0;
        for &depth in &self.depths {
            while at < last && run[at].depth < depth {
                at += 1;
            }
            let mut layer = at;
            while layer < last && run[layer + 1].depth == depth {
                layer += 1;
            }
            let falls = layer > 0 && run[layer].visibility != run[layer - 1].visibility;
            if layer < last && (layer == 0 || (!falls && run[layer].depth == depth)) {
                layer += 1;
            }
            run[layer].count += 1;
        }
    }

    /// Leaves out the layers behind as many as a pixel may have; whether there
    /// were any, and how much light they would have stopped.
    fn cut(&mut self, first: usize, falls: &mut u32) -> (bool, f64) {
        let run = &self.layers[first..];
        let left = |layer: Option<&Layer<T>>, channel: usize| {
            layer.map_or(1.0, |layer| f64::from(layer.visibility.channel(channel)))
        };
        for (index, pair) in run.windows(2).enumerate() {
            if pair[0].visibility == pair[1].visibility {
                continue;
            }
            if *falls == self.max_layers {
                // Not even the first layer, which starts the run.
                let kept = if index == 0 { 0 } else { index + 1 };
                let stopped =
                    |channel| left(run[..kept].last(), channel) - left(run.last(), channel);
                let gained = (0..T::CHANNELS).map(stopped).fold(0.0, f64::max);
                self.layers.truncate(first + kept);
                return (true, gained);
            }
            *falls += 1;
        }
        (false, 0.0)
    }

    /// How far the run is from the function that it stands for.
    fn difference(&self, first: usize) -> VisibilityDifference {
        let vertex = |layer: &Layer<T>| Vertex::new(layer.depth, layer.visibility.to_sum());
        let stored: Vec<SumVertex<T>> = self.layers[first..].iter().map(vertex).collect();
        VisibilityDifference::between(self.exact.as_slice(), stored.as_slice())
    }
}
