//! From what a shadow camera sees to a map of fragments.

use dsm_core::{
    Error, HitSource, PixelSampling, Result, ShadowCamera, TileHits, TileSamples, Transmittance,
};
use rayon::prelude::*;

use crate::{Fragment, FragmentColumns, FragmentMap, LightFrame};

/// Pixels along the side of what is asked for at once.
const TILE: u32 = 32;

/// How far two hits of a pixel may lie from each other's planes and still be one
/// fragment: in sides of a pixel at their depth. More, and lit surfaces shade
/// themselves.
const SAME_PLANE: f64 = 0.05;

/// The same for hits without a normal, whose depth within the pixel is unknown.
const SAME_DEPTH: f64 = 0.2;

/// Builds a [`FragmentMap`] from what a [`HitSource`] shows at 1, 2 × 2, 4 × 4
/// or 8 × 8 places of each pixel, when the shutter is half way.
///
/// Hits of a pixel that lie in one plane, do not overlap and are equally opaque
/// become one fragment. Hits without a normal, as of strands, face the camera.
/// What lies at the light's depth or nearer is left out. Every pixel is a
/// function of its own samples: the same on any number of threads.
///
/// ```
/// use dsm_core::{Error, RayHits, RaySource, SamplePoint, ShadowCamera, SurfaceHit};
/// use glam::{Mat4, Vec4};
/// use mtsm::{FragmentBuilder, LightFrame};
///
/// # let to_ndc = Mat4::from_cols(
/// #     Vec4::new(0.5, 0.0, 0.0, 0.0),
/// #     Vec4::new(0.0, -0.5, 0.0, 0.0),
/// #     Vec4::new(-0.5, -0.5, -1.0, -1.0),
/// #     Vec4::ZERO,
/// # );
/// # let camera =
/// #     ShadowCamera { world_to_camera: Some(Mat4::IDENTITY), world_to_ndc: Some(to_ndc) };
/// // An opaque half plane at depth 4 that begins in the middle of pixel 2.
/// let source = RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     if point.x > 2.5 {
///         ray.push_surface(SurfaceHit { depth: 4.0, opacity: 1.0 })?;
///     }
///     Ok(())
/// });
/// let builder = FragmentBuilder::new(camera, [4, 4], 0.0)?.with_coverage(8)?;
/// let map = builder.build(&source)?;
/// assert_eq!(map.pixel(1, 0).len(), 0);
/// assert_eq!(map.pixel(2, 0).next().unwrap().coverage, 0xf0f0_f0f0_f0f0_f0f0);
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct FragmentBuilder {
    camera: ShadowCamera,
    frame: LightFrame,
    coverage: u32,
    sampling: PixelSampling,
    layers: u32,
}

/// One hit of a pixel.
#[derive(Clone, Copy, Debug)]
struct PixelHit<T> {
    /// At the place of the sample.
    w: f64,
    sample: u32,
    gradient: Option<[f64; 2]>,
    opacity: T,
}

/// Hits of a pixel in one plane.
#[derive(Clone, Copy, Debug)]
struct Group<T> {
    first: PixelHit<T>,
    nearest: f64,
    coverage: u64,
}

impl FragmentBuilder {
    /// The most layers a pixel may be asked to keep.
    pub const MAX_LAYERS: u32 = 1 << 20;

    /// For a map of `size` pixels that `camera`'s NDC \[0, 1\]² covers, with
    /// the light's centre at `light_depth` on its axis: 8 × 8 places a pixel,
    /// all layers.
    ///
    /// # Errors
    ///
    /// As [`LightFrame::new`].
    pub fn new(camera: ShadowCamera, size: [u32; 2], light_depth: f64) -> Result<Self> {
        let frame = LightFrame::new(&camera, size, light_depth)?;
        let sampling = PixelSampling::grid(8)?;
        Ok(Self { camera, frame, coverage: 8, sampling, layers: Self::MAX_LAYERS })
    }

    /// The same with `side` × `side` places a pixel.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless it is 1, 2, 4 or 8.
    pub fn with_coverage(self, side: u32) -> Result<Self> {
        if ![1, 2, 4, 8].contains(&side) {
            return Err(Error::Setting { setting: "coverage", reason: "it must be 1, 2, 4 or 8" });
        }
        Ok(Self { coverage: side, sampling: PixelSampling::grid(side)?, ..self })
    }

    /// The same with at most `layers` fragments a pixel: those nearest to the
    /// light (Xie et al. 2007, §4.2). Where a pixel shows more, shadows get
    /// lighter.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for none.
    pub fn with_layers(self, layers: u32) -> Result<Self> {
        if layers == 0 {
            return Err(Error::Setting { setting: "layers", reason: "there must be one or more" });
        }
        Ok(Self { layers: layers.min(Self::MAX_LAYERS), ..self })
    }

    /// The camera of the map.
    #[must_use]
    pub const fn camera(&self) -> &ShadowCamera {
        &self.camera
    }

    /// Places along a side of a pixel.
    #[must_use]
    pub const fn coverage(&self) -> u32 {
        self.coverage
    }

    /// The most fragments of a pixel.
    #[must_use]
    pub const fn layers(&self) -> u32 {
        self.layers
    }

    /// The frame of the map.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// Asks `source` for all pixels, 32 × 32 at a time, in parallel. O(h log h)
    /// for the h hits of a pixel, and O(h) for each fragment in it.
    ///
    /// # Errors
    ///
    /// Those of the source; [`Error::Setting`] if it shows media, which a
    /// fragment cannot hold; [`Error::TooLarge`] past 2³² fragments.
    pub fn build<T, S>(&self, source: &S) -> std::result::Result<FragmentMap<T>, S::Error>
    where
        T: Transmittance,
        S: HitSource<T>,
    {
        let [width, height] = self.frame.size();
        let (columns, rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let mut map = FragmentColumns {
            offsets: vec![0],
            w: Vec::new(),
            gradients: [Vec::new(), Vec::new()],
            opacities: Vec::new(),
            coverage: Vec::new(),
        };
        // A row of tiles at a time, so that no more is held twice.
        for row in 0..rows {
            let tiles: std::result::Result<Vec<_>, S::Error> = (0..columns)
                .into_par_iter()
                .map(|column| {
                    let min = [column * TILE, row * TILE];
                    let size = [width - min[0], height - min[1]].map(|side| side.min(TILE));
                    self.tile(source, min, size)
                })
                .collect();
            let tiles = tiles?;
            for y in 0..TILE.min(height - row * TILE) {
                for (lists, side) in &tiles {
                    let pixels = (y * side) as usize..((y + 1) * side) as usize;
                    for list in &lists[pixels] {
                        list.iter().for_each(|fragment| push(&mut map, fragment));
                        let count = map.w.len() as u64;
                        let limit = u64::from(u32::MAX);
                        if count > limit {
                            return Err(Error::TooLarge { what: "fragments", count, limit }.into());
                        }
                        map.offsets.push(count as u32);
                    }
                }
            }
        }
        Ok(FragmentMap::new(self.frame, map)?)
    }

    /// The fragments of a block of pixels, and its width.
    #[expect(clippy::type_complexity, reason = "only the tile's lists and their row length")]
    fn tile<T, S>(
        &self,
        source: &S,
        min: [u32; 2],
        size: [u32; 2],
    ) -> std::result::Result<(Vec<Vec<Fragment<T>>>, u32), S::Error>
    where
        T: Transmittance,
        S: HitSource<T>,
    {
        let camera = Some((&self.camera, self.frame.size()));
        // Maps have at most 2²⁴ pixels a side.
        let corner = min.map(|side| side as i32);
        let samples = TileSamples::new(&self.sampling, corner, size, camera)?;
        let mut hits = TileHits::with_normals(samples.len());
        source.hits(&samples, &mut hits)?;
        if !hits.segments().is_empty() {
            let reason = "a fragment map holds surfaces, no media";
            return Err(Error::Setting { setting: "scene", reason }.into());
        }
        let per_pixel = samples.samples_per_pixel();
        let pixels = (size[0] * size[1]) as usize;
        let mut lists: Vec<Vec<PixelHit<T>>> = vec![Vec::new(); pixels];
        let mut normals = hits.normals().iter().peekable();
        for (index, (sample, hit)) in (0_u32..).zip(hits.surfaces()) {
            let normal = normals.next_if(|(of, _)| *of == index).map(|&(_, normal)| normal);
            let depth = f64::from(hit.depth);
            if depth <= self.frame.light_depth() || depth <= 0.0 {
                continue;
            }
            let (x, y) = (samples.x()[sample as usize], samples.y()[sample as usize]);
            let gradient =
                normal.and_then(|normal| self.frame.plane(x, y, depth, normal.as_dvec3()));
            let of = PixelHit {
                w: depth.recip(),
                sample: sample % per_pixel,
                gradient,
                opacity: hit.opacity,
            };
            if of.w.is_finite() {
                lists[(sample / per_pixel) as usize].push(of);
            }
        }
        let mut groups = Vec::new();
        let lists = lists.into_iter().map(|mut list| self.fragments(&mut list, &mut groups));
        Ok((lists.collect(), size[0]))
    }

    /// The fragments of a pixel's hits, the farthest first.
    fn fragments<T: Transmittance>(
        &self,
        hits: &mut [PixelHit<T>],
        groups: &mut Vec<Group<T>>,
    ) -> Vec<Fragment<T>> {
        // The order in which a source finds things must not show.
        hits.sort_by(|a, b| {
            let order = a.w.total_cmp(&b.w).then(a.sample.cmp(&b.sample));
            order.then_with(|| {
                let opacity = |hit: &PixelHit<T>| hit.opacity.channel(0);
                opacity(a).total_cmp(&opacity(b))
            })
        });
        groups.clear();
        for hit in &*hits {
            let bit = self.squares(hit.sample);
            let fits = |group: &&mut Group<T>| {
                group.coverage & bit == 0
                    && group.first.opacity == hit.opacity
                    && self.in_one_plane(&group.first, hit)
            };
            match groups.iter_mut().rev().find(fits) {
                Some(group) => {
                    group.coverage |= bit;
                    group.nearest = group.nearest.max(hit.w);
                }
                None => groups.push(Group { first: *hit, nearest: hit.w, coverage: bit }),
            }
        }
        if groups.len() > self.layers as usize {
            groups.sort_by(|a, b| b.nearest.total_cmp(&a.nearest));
            groups.truncate(self.layers as usize);
        }
        let mut list: Vec<_> = groups.iter().map(|group| self.fragment(group)).collect();
        list.sort_by(|a, b| {
            let key = |one: &Fragment<T>| (one.coverage, one.opacity.channel(0).to_bits());
            a.w.total_cmp(&b.w).then_with(|| key(a).cmp(&key(b)))
        });
        list
    }

    /// Whether each hit lies in the plane of the other, as far as a map can
    /// tell.
    fn in_one_plane<T>(&self, a: &PixelHit<T>, b: &PixelHit<T>) -> bool {
        let near = |sides: f64| sides * self.frame.footprint(1.0) * a.w.max(b.w);
        let [dx, dy] = self.between(a.sample, b.sample);
        let step = |gradient: [f64; 2]| gradient[0] * dx + gradient[1] * dy;
        match (a.gradient, b.gradient) {
            (None, None) => (b.w - a.w).abs() <= near(SAME_DEPTH),
            (Some(of_a), Some(of_b)) => {
                let apart = [of_a, of_b].map(|of| (b.w - a.w - step(of)).abs());
                apart[0].max(apart[1]) <= near(SAME_PLANE)
            }
            _ => false,
        }
    }

    fn fragment<T: Transmittance>(&self, group: &Group<T>) -> Fragment<T> {
        let PixelHit { w, sample, gradient, opacity } = group.first;
        let coverage = group.coverage;
        let gradient32 = gradient.map(|gradient| gradient.map(|along| along as f32 + 0.0));
        match (gradient, gradient32) {
            (Some(along), Some(gradient)) if gradient.iter().all(|along| along.is_finite()) => {
                let [x, y] = self.place(sample);
                let w = w + along[0] * (0.5 - x) + along[1] * (0.5 - y);
                Fragment { w: w as f32, gradient, opacity, coverage }
            }
            _ => Fragment { w: w as f32, gradient: Fragment::<T>::FACING, opacity, coverage },
        }
    }

    /// Where a sample is in its pixel.
    fn place(&self, sample: u32) -> [f64; 2] {
        let side = self.coverage;
        [sample % side, sample / side].map(|at| (f64::from(at) + 0.5) / f64::from(side))
    }

    fn between(&self, a: u32, b: u32) -> [f64; 2] {
        let (a, b) = (self.place(a), self.place(b));
        [b[0] - a[0], b[1] - a[1]]
    }

    /// The squares of the mask that a sample stands for.
    fn squares(&self, sample: u32) -> u64 {
        let side = 8 / self.coverage;
        let (column, row) = (sample % self.coverage * side, sample / self.coverage * side);
        let line = ((1_u64 << side) - 1) << column;
        (row..row + side).fold(0, |bits, row| bits | line << (8 * row))
    }
}

fn push<T: Transmittance>(map: &mut FragmentColumns<T>, fragment: &Fragment<T>) {
    map.w.push(fragment.w);
    map.gradients[0].push(fragment.gradient[0]);
    map.gradients[1].push(fragment.gradient[1]);
    map.opacities.push(fragment.opacity);
    map.coverage.push(fragment.coverage);
}
