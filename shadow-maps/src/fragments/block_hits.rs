//! The hits of a block of pixels, in the order in which fragments are made of
//! them.

use dsm_core::{TileHits, TileSamples, Transmittance};
use dsm_trace::detail::LightFrame;

use super::groups::PixelHit;

/// Hits of a block, pixel by pixel, the farthest first: in columns that keep
/// their memory from block to block.
#[derive(Debug)]
pub(crate) struct BlockHits<T> {
    /// Where the hits of each sample begin, and where the last end.
    starts: Vec<u32>,
    /// For each hit its place in the other columns, below what is less for
    /// larger depths.
    keys: Vec<u64>,
    /// Samples of their pixels, of which there are 64 at most, and
    /// [`HAS_GRADIENT`].
    samples: Vec<u8>,
    opacities: Vec<T>,
    /// Of hits without a normal anything.
    gradients: Vec<[f64; 2]>,
}

impl<T> Default for BlockHits<T> {
    fn default() -> Self {
        Self {
            starts: Vec::new(),
            keys: Vec::new(),
            samples: Vec::new(),
            opacities: Vec::new(),
            gradients: Vec::new(),
        }
    }
}

/// That a hit has a gradient: of hair few do, and those of others are not read.
const HAS_GRADIENT: u8 = 0x80;

/// What orders hits of a pixel: far ones first, and of one depth by `place`.
fn key(depth: f32, place: u32) -> u64 {
    u64::from(!depth.to_bits()) << 32 | u64::from(place)
}

fn depth(key: u64) -> f64 {
    f64::from(f32::from_bits(!((key >> 32) as u32)))
}

impl<T: Transmittance> BlockHits<T> {
    /// Takes the hits of a block that lie deeper than the light, in O(samples +
    /// hits).
    pub(crate) fn fill(&mut self, frame: &LightFrame, samples: &TileSamples, hits: &TileHits<T>) {
        let light_depth = frame.light_depth();
        let is_seen = |depth: f32| f64::from(depth) > light_depth && depth > 0.0;
        // Sample by sample, which makes the order of each pixel's samples, too.
        self.starts.clear();
        self.starts.resize(samples.len() as usize + 1, 0);
        for (sample, hit) in hits.surfaces() {
            self.starts[sample as usize] += u32::from(is_seen(hit.depth));
        }
        let mut count = 0;
        for start in &mut self.starts {
            // Where the sample's next hit goes; where it ends, when all are there.
            count += std::mem::replace(start, count);
        }
        let count = count as usize;
        self.keys.resize(count, 0);
        self.samples.resize(count, 0);
        self.opacities.resize(count, T::BLOCKED);
        if !hits.normals().is_empty() {
            self.gradients.resize(count, [0.0; 2]);
        }
        let per_pixel = samples.samples_per_pixel();
        let mut normals = hits.normals().iter().peekable();
        for (index, (sample, hit)) in (0_u32..).zip(hits.surfaces()) {
            let normal = normals.next_if(|(of, _)| *of == index).map(|&(_, normal)| normal);
            if !is_seen(hit.depth) {
                continue;
            }
            let place = self.starts[sample as usize];
            self.starts[sample as usize] += 1;
            self.keys[place as usize] = key(hit.depth, place);
            let mut of_pixel = (sample % per_pixel) as u8;
            if let Some(normal) = normal {
                let (x, y) = (samples.x()[sample as usize], samples.y()[sample as usize]);
                let depth = f64::from(hit.depth);
                if let Some(gradient) = frame.plane(x, y, depth, normal.as_dvec3()) {
                    self.gradients[place as usize] = gradient;
                    of_pixel |= HAS_GRADIENT;
                }
            }
            self.samples[place as usize] = of_pixel;
            self.opacities[place as usize] = hit.opacity;
        }
    }

    /// The hits of the block's pixel of samples `first` to `last`, with growing
    /// w. Sorts them: O(h log h). The order in which a source finds things does
    /// not show.
    pub(crate) fn pixel(
        &mut self,
        first: u32,
        last: u32,
    ) -> impl Iterator<Item = PixelHit<T>> + '_ {
        // Each start has moved to its end.
        let at = |sample: u32| match sample {
            0 => 0,
            _ => self.starts[sample as usize - 1] as usize,
        };
        let range = at(first)..at(last);
        let Self { keys, samples, opacities, gradients, .. } = self;
        let keys = &mut keys[range];
        keys.sort_unstable();
        let place = |key: u64| key as u32 as usize;
        let sample = |key: u64| samples[place(key)] & !HAS_GRADIENT;
        let is_same = |&a: &u64, &b: &u64| a >> 32 == b >> 32 && sample(a) == sample(b);
        // Where a ray meets several things at once, as the edge of two triangles.
        for same in keys.chunk_by_mut(is_same).filter(|same| same.len() > 1) {
            let order = |key: u64| {
                let place = place(key);
                let opacity = [0, 1, 2].map(|channel| {
                    if channel < T::CHANNELS { opacities[place].channel(channel) } else { 0.0 }
                });
                let has_gradient = samples[place] & HAS_GRADIENT != 0;
                let gradient = if has_gradient { gradients[place] } else { [0.0; 2] };
                // No value is negative or NaN but those of gradients.
                let bits = gradient.map(f64::to_bits);
                (opacity.map(f32::to_bits), has_gradient, bits)
            };
            same.sort_by_key(|&key| order(key));
        }
        keys.iter().map(move |&key| {
            let place = place(key);
            let has_gradient = samples[place] & HAS_GRADIENT != 0;
            PixelHit {
                w: depth(key).recip(),
                sample: samples[place] & !HAS_GRADIENT,
                gradient: has_gradient.then(|| gradients[place]),
                opacity: opacities[place],
            }
        })
    }
}
