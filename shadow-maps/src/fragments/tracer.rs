//! Soft shadows by tracing a map of fragments.

use std::convert::Infallible;
use std::marker::PhantomData;
use std::sync::Arc;

use dsm_core::detail::{LightShape, Result};
use dsm_core::{AreaLight, Facing, LightVisibility, OcclusionTracer, ShadedPoint, Transmittance};
use dsm_io::detail::KindReader;
use dsm_trace::detail::{LightFrame, TraceCounters, TraceStatistics};
use fearless_simd::{Level, Simd, SimdBase, dispatch, f32x16};
use glam::DVec3;
use rayon::prelude::*;

use super::apex::Apex;
use super::cone::Cone;
use super::far_field::FarField;
use super::frontier::{Frontier, whole};
use super::group_occlusion::is_blocked;
use super::kernel::{Stacks, Stage, trace};
use super::lane_count::LANES;
use super::lanes::Lanes;
use super::map::FragmentMap;
use super::media::tracer::{TracedMedia, TracedMediaBuilder};
use super::packed::{PackedBuilder, PackedFragments};
use super::packet::{Packet, Reach, Starts};
use super::range_tree::RangeTree;
use super::store::{Fragments, frame_of};

/// Where rays begin to meet fragments without a plane, in sides of a pixel at their
/// receiver: their depth is known at some place of their pixel, as far from its middle as
/// its borders are, or so.
const FACING_START: f64 = 0.5;

/// Packets that share a frontier: 256 rays.
const PACKETS: usize = 16;

/// Receivers that a thread takes at once.
const CHUNK: usize = 64;

/// Traces shadow rays through a [`FragmentMap`] (Xie et al. 2007, §4.3, with
/// exact planes in place of the depth threshold of §6.1).
///
/// A ray takes the opacity of every fragment whose plane it crosses where it is
/// covered, within the fragment's pixel. The rays of a receiver start at one
/// place of the raster: what all of them cannot reach is found first, then what
/// each 16 cannot, and single rays where 16 have gone apart. All receivers are
/// independent; answers do not depend on threads or processors.
///
/// Media count from the receiver on, wherever it is in them: the optical depth of slabs, by
/// how deep a ray is in each and how far it goes for that.
///
/// A receiver may lie on a fragment: that does not shade it, but for the rays that go
/// through the surface, if [`LightVisibility::visibilities`] is told its side
/// ([`Facing::Surface`]): those it takes its opacity from.
///
/// Receivers no deeper than the light and those that are not finite are lit, as
/// is what a ray does outside the raster: [`Self::statistics`] counts them.
///
/// ```
/// use dsm_core::{AreaLight, Error, LightVisibility, RayHits, RaySource, SamplePoint};
/// use dsm_core::{ShadowCamera, SurfaceHit};
/// use glam::{DVec3, DMat4, DVec4};
/// use shadow_maps::detail::{FragmentBuilder, FragmentTracer};
///
/// # let to_ndc = DMat4::from_cols(
/// #     DVec4::new(0.5, 0.0, 0.0, 0.0),
/// #     DVec4::new(0.0, -0.5, 0.0, 0.0),
/// #     DVec4::new(-0.5, -0.5, -1.0, -1.0),
/// #     DVec4::ZERO,
/// # );
/// # let camera =
/// #     ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) };
/// // An opaque half plane at depth 2, right of the camera's axis.
/// let source = RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     if point.x > 32.0 {
///         ray.push_surface(SurfaceHit { depth: 2.0, opacity: 1.0 })?;
///     }
///     Ok(())
/// });
/// let map = FragmentBuilder::new(camera, [64, 64], 0.0)?.build(&source)?;
/// let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5);
/// let tracer = FragmentTracer::new(map)?;
/// // Straight behind the edge, half of the light is seen.
/// let Ok(half) = tracer.visibility(DVec3::new(0.0, 0.0, -4.0), &light, 0);
/// assert!((half - 0.5).abs() < 0.02);
/// let Ok(lit) = tracer.visibility(DVec3::new(-2.0, 0.0, -4.0), &light, 0);
/// assert_eq!(lit, 1.0);
/// # Ok::<(), Error>(())
/// ```
pub struct FragmentTracer<T> {
    pub(super) frame: LightFrame,
    /// Number of fragments.
    pub(super) count: usize,
    pub(super) fragments: PackedFragments,
    pub(super) media: Option<TracedMedia<T>>,
    tree: RangeTree,
    /// The w of all fragments, and with those of media.
    range: [f32; 2],
    reach: [f32; 2],
    rays: u32,
    starts: Starts,
    least: f32,
    pub(super) far: Option<FarField>,
    /// Coarse pixels that rays move before the table takes over.
    near_cells: f32,
    level: Level,
    pub(super) counters: TraceCounters,
}

/// Scratch memory of a thread that traces, kept from receiver to receiver.
#[derive(Clone, Debug, Default)]
pub struct TraceScratch {
    /// Of what is near, and of what is far.
    frontiers: [Frontier; 2],
    stacks: Stacks,
    lights: Vec<DVec3>,
}

impl<T: Transmittance> FragmentTracer<T> {
    /// Coarse pixels that rays move before a far table takes over. What is nearer is
    /// what a receiver itself is part of: with 0.5 strands of a ball of hair have an RMSE
    /// of 0.012, with 1.125 of 0.005 and two thirds of the speed.
    pub const NEAR_CELLS: f32 = 1.125;

    /// A tracer of `map`: 256 rays a light. It keeps fragments of its own, in other
    /// places than the map. O(pixels + fragments · log fragments of a block).
    ///
    /// # Errors
    ///
    /// [`dsm_core::Error::TooLarge`] past some 590 million fragments.
    pub fn new(map: impl Into<Arc<FragmentMap<T>>>) -> Result<Self> {
        let map = map.into();
        let media = map.media().map(|media| TracedMedia::new(map.size(), media)).transpose()?;
        Ok(Self::of(*map.frame(), PackedFragments::new(&map)?, media.flatten()))
    }

    /// A tracer of a file's map, its finest level: reads tile by tile, and holds no
    /// fragment twice but those of one row of tiles.
    ///
    /// # Errors
    ///
    /// [`dsm_io::Error::Channels`] for a map of another number of channels,
    /// [`dsm_io::Error::Limit`] for one that is too large, or what is wrong with a
    /// tile; as [`Self::new`].
    pub fn read(reader: &KindReader<Fragments>) -> dsm_io::detail::Result<Self> {
        reader.check_channels::<T>()?;
        reader.check_in_memory(0)?;
        let container = reader.container();
        let frame = container.in_file(frame_of(reader).map_err(dsm_io::Error::from))?;
        // No more than their tiles have bytes for.
        let each = 4 * (5 + T::CHANNELS) as u64;
        let tiles = reader.directory(0)?.iter().map(|(_, tile)| tile);
        let most = tiles.map(|tile| tile.vertex_count.min(tile.raw_length / each));
        let builder = PackedBuilder::new(frame.size(), most.fold(0, u64::saturating_add));
        let mut builder = container.in_file(builder.map_err(dsm_io::Error::from))?;
        let mut media = TracedMediaBuilder::new(frame.size());
        reader.for_each_pixel::<T>(0, |tile, pixel| {
            builder.push_pixel(tile.fragments(pixel))?;
            if let Some(of_tile) = tile.media() {
                media.push_pixel(of_tile.pixel(pixel))?;
            }
            Ok(())
        })?;
        Ok(Self::of(frame, builder.finish(), media.finish()))
    }

    fn of(frame: LightFrame, fragments: PackedFragments, media: Option<TracedMedia<T>>) -> Self {
        let mut tree = RangeTree::new(frame.size());
        let mut count = 0;
        fragments.for_each::<T>(|pixel, fragment| {
            tree.include(pixel, fragment.range());
            count += 1;
        });
        let range = tree.range().unwrap_or([f32::INFINITY, f32::NEG_INFINITY]);
        let of_media = media.as_ref().map_or(range, TracedMedia::range);
        let reach = [range[0].min(of_media[0]), range[1].max(of_media[1])];
        Self {
            frame,
            count,
            fragments,
            media,
            tree,
            range,
            reach,
            rays: 256,
            starts: Starts::Surface(FACING_START),
            least: 1e-3,
            far: None,
            near_cells: Self::NEAR_CELLS,
            level: Level::new(),
            counters: TraceCounters::default(),
        }
    }

    /// Sets the number of rays a light, 1 or more.
    #[must_use]
    pub fn with_rays(self, rays: u32) -> Self {
        Self { rays: rays.max(1), ..self }
    }

    /// Sets the ray offsets in scene units: `plane` for fragments with a plane,
    /// `facing` for those without a normal. Both 0 or more. What a receiver lies on then
    /// counts as all else. By default rays start at the receiver and pass over the
    /// surface that it lies on, and start half a pixel's side away for fragments without
    /// a normal.
    #[must_use]
    pub fn with_start(self, plane: f64, facing: f64) -> Self {
        Self { starts: Starts::Distances([plane.max(0.0), facing.max(0.0)]), ..self }
    }

    /// Sets a far table: sums of optical depth in place of strands and of leaves smaller
    /// than a pixel, beyond the first `cells` coarse pixels that rays move. Coherent
    /// surfaces, which fill pixels, are traced one by one all the way. None where those
    /// are most of the map, or there is no room for both parts.
    #[must_use]
    pub fn with_far_table(self, cells: f32) -> Self {
        let far = (self.range[0] < self.range[1])
            .then(|| FarField::new::<T>(&self.fragments, &self.frame, self.range));
        let far = far.and_then(|far| far.ok().flatten());
        Self { far, near_cells: cells.max(0.0), ..self }
    }

    /// True if a far table is used.
    #[must_use]
    pub const fn has_far_table(&self) -> bool {
        self.far.is_some()
    }

    /// Sets the minimum transmittance: rays end, dark, below `least`, in [0, 1],
    /// 0.001 by default.
    #[must_use]
    pub fn with_least_light(self, least: f32) -> Self {
        Self { least: least.clamp(0.0, 1.0), ..self }
    }

    /// The same with the instructions of another level of processors.
    #[cfg(test)]
    pub(crate) fn with_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// The light's frame.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// Counts of the rays traced so far, without the trial of [`Self::for_light`].
    #[must_use]
    pub fn statistics(&self) -> TraceStatistics {
        self.counters.get()
    }

    /// The mean light that gets from `lights`, points of the world, to
    /// `receiver`. Fastest where each 16 that follow each other lie close
    /// together. 1 for no points.
    #[must_use]
    pub fn mean(&self, receiver: DVec3, lights: &[DVec3], scratch: &mut TraceScratch) -> T {
        self.mean_at(receiver, Facing::Light, lights, scratch)
    }

    fn mean_at(
        &self,
        receiver: DVec3,
        facing: Facing,
        lights: &[DVec3],
        scratch: &mut TraceScratch,
    ) -> T {
        let mut sum = T::BLOCKED.to_sum();
        let mut counted = TraceStatistics { rays: lights.len() as u64, ..Default::default() };
        let Some(apex) = Apex::new(&self.frame, receiver, facing) else {
            self.counters.add(TraceStatistics { behind_light: counted.rays, ..counted });
            return T::CLEAR;
        };
        if lights.is_empty() {
            return T::CLEAR;
        }
        let (apex, surface) = match (self.starts, facing) {
            (Starts::Distances(_), _) => (apex.without_surface(), None),
            // Off its strand by its radius.
            (_, Facing::Strand(_)) => (apex, None),
            _ => apex.on_surface::<T>(&self.fragments),
        };
        for group in lights.chunks(PACKETS * LANES) {
            let own = (&mut scratch.frontiers, &mut scratch.stacks);
            let leaving = dispatch!(self.level, simd => self.group(simd, (&apex, surface), group, own, &mut sum));
            counted.outside_map += u64::from(leaving);
        }
        self.counters.add(counted);
        let share = (lights.len() as f64).recip();
        sum.as_mut().iter_mut().for_each(|part| *part *= share);
        T::from_sum(sum)
    }

    #[inline(always)]
    fn group<S: Simd>(
        &self,
        simd: S,
        (apex, surface): (&Apex, Option<T>),
        lights: &[DVec3],
        ([frontier, far_frontier], stacks): (&mut [Frontier; 2], &mut Stacks),
        sum: &mut T::Sum,
    ) -> u32 {
        let frame = &self.frame;
        let mut packets = [const { None }; PACKETS];
        let mut count = 0;
        let mut leaving = 0;
        for lights in lights.chunks(LANES) {
            let packet = Packet::new(simd, frame, apex, lights, self.starts, self.reach);
            leaving += packet.leaving.count_ones();
            packets[count] = Some(packet);
            count += 1;
        }
        let packets = &packets[..count];
        let cone = whole(packets.iter().flatten(), apex);
        frontier.fill(simd, &self.tree, &cone);
        let behind = packets.iter().flatten().any(|packet| packet.behind != 0);
        let surface = surface.filter(|_| behind);
        let is_clear = frontier.is_empty() && surface.is_none();
        if is_clear && self.media.is_none() {
            let clear = lights.len() as f64;
            sum.as_mut().iter_mut().for_each(|part| *part += clear);
            return leaving;
        }
        let Self { fragments, tree, least, .. } = self;
        let stage = Stage { fragments, tree, apex, least: *least, value: PhantomData::<T> };
        // Where the table takes over.
        let steepest =
            cone.slopes.as_flattened().iter().fold(0.0, |most: f32, q| most.max(q.abs()));
        let far = self.far.as_ref().map(|far| (far, far.table.reach(self.near_cells, steepest)));
        if let Some((_, cut)) = far {
            frontier.fill(simd, &self.tree, &Cone { far: cone.far.min(cut), ..cone });
        }
        let cut = far.map_or(f32::INFINITY, |(_, cut)| cut);
        let reach = packets.iter().flatten().map(|packet| packet.reach);
        let reach = reach.fold(Reach { starts: [0.0; 2], end: cut }, Reach::and);
        if !is_clear && is_blocked(simd, &stage, frame.size(), &cone, reach) {
            return leaving;
        }
        for (packet, lights) in packets.iter().flatten().zip(lights.chunks(LANES)) {
            let mut lanes = Lanes::new(simd, packet, cut);
            let cone = Cone { far: packet.cone.far.min(cut), ..packet.cone };
            if let Some(opacity) = surface.filter(|_| packet.behind != 0) {
                lanes.take_some(packet.behind, opacity);
                lanes.stop::<S, T>(simd, *least);
            }
            trace(simd, &stage, frontier, &cone, stacks, &mut lanes);
            if let Some((far, _)) = far.filter(|_| lanes.live != 0 && cut < packet.cone.far) {
                lanes.go_on(simd, packet, cut);
                let FarField { coherent, tree, .. } = far;
                let stage = Stage { fragments: coherent, tree, ..stage };
                let cone = Cone { near: packet.cone.near.max(cut), ..packet.cone };
                far_frontier.fill(simd, tree, &cone);
                trace(simd, &stage, far_frontier, &cone, stacks, &mut lanes);
                let end = f32x16::load_array_ref(simd, &packet.end);
                let left = far.table.left(simd, apex, packet, cut, end);
                for (own, left) in lanes.left.iter_mut().zip(left) {
                    *own = (f32x16::load_array_ref(simd, own) * left).to_array();
                }
                lanes.stop::<S, T>(simd, *least);
            }
            if let Some(media) = self.media.as_ref().filter(|_| lanes.live != 0) {
                let left = media.left(simd, (frame, apex), (packet, lights), lanes.live);
                for (own, left) in lanes.left.iter_mut().zip(left) {
                    *own = (f32x16::load_array_ref(simd, own) * left).to_array();
                }
                lanes.stop::<S, T>(simd, *least);
            }
            for (channel, part) in sum.as_mut().iter_mut().enumerate() {
                let left = &lanes.left[channel][..lights.len()];
                *part += left.iter().map(|&left| f64::from(left)).sum::<f64>();
            }
        }
        leaving
    }

    /// The points of `light`, so that each 16 that follow each other lie close
    /// together.
    fn samples(&self, receiver: DVec3, light: &AreaLight, seed: u64, into: &mut Vec<DVec3>) {
        into.clear();
        let rays = if light.shape() == LightShape::Point { 1 } else { self.rays };
        into.extend(light.samples(receiver, rays, seed));
        // Sample i of n lies in column i of n, in a row whose first bits are the
        // last of i: a stripe of columns, cut by the last bits, makes blocks.
        let stripes = ((rays as usize / LANES) as f64).sqrt() as usize;
        if stripes > 1 && (rays as usize).is_multiple_of(stripes) {
            let ordered: Vec<_> = into
                .chunks(rays as usize / stripes)
                .flat_map(|stripe| {
                    (0..stripes).flat_map(move |row| stripe.iter().skip(row).step_by(stripes))
                })
                .copied()
                .collect();
            *into = ordered;
        }
    }

    pub(super) fn visibility_with(
        &self,
        &ShadedPoint { position, facing, seed }: &ShadedPoint,
        light: &AreaLight,
        scratch: &mut TraceScratch,
    ) -> T {
        let mut lights = std::mem::take(&mut scratch.lights);
        self.samples(position, light, seed, &mut lights);
        let mean = self.mean_at(position, facing, &lights, scratch);
        scratch.lights = lights;
        mean
    }
}

impl<T: Transmittance> OcclusionTracer for FragmentTracer<T> {
    type Value = T;
    type Error = Infallible;

    /// At any time: a map of fragments stands still.
    fn transmittance(
        &self,
        receiver: DVec3,
        light: DVec3,
        _time: f64,
    ) -> std::result::Result<T, Infallible> {
        Ok(self.mean(receiver, &[light], &mut TraceScratch::default()))
    }
}

impl<T: Transmittance> LightVisibility for FragmentTracer<T> {
    type Value = T;
    type Error = Infallible;

    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> std::result::Result<T, Infallible> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        Ok(self.visibility_with(&point, light, &mut TraceScratch::default()))
    }

    /// Points in parallel.
    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<T>,
    ) -> std::result::Result<(), Infallible> {
        let first = values.len();
        values.resize(first + points.len(), T::CLEAR);
        let chunks = values[first..].par_chunks_mut(CHUNK).zip(points.par_chunks(CHUNK));
        chunks.for_each_init(TraceScratch::default, |scratch, (values, points)| {
            for (value, point) in values.iter_mut().zip(points) {
                *value = self.visibility_with(point, light, scratch);
            }
        });
        Ok(())
    }
}
