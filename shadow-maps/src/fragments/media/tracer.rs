//! The optical depth of media along shadow rays.

use dsm_core::Transmittance;
use dsm_core::detail::Result;
use dsm_trace::detail::LightFrame;
use fearless_simd::{Simd, SimdBase, f32x16};
use glam::DVec3;

use super::super::apex::Apex;
use super::super::exponential::exponential;
use super::super::lane_count::LANES;
use super::super::packet::Packet;
use super::super::range_tree::bits;
use super::columns::MediaColumns;
use super::walk::{Extent, MediaRay};

/// Optical depths beyond this leave nothing that `f32` can tell from nothing.
const DARK: f64 = 104.0;

/// The media of a map as they are traced: for each pixel the borders of its slabs, front to
/// back, each with the extinction behind it.
#[derive(Debug)]
pub(crate) struct TracedMedia<T> {
    width: usize,
    /// Number of empty pixels, whole rows, that `columns` leaves out.
    skipped: usize,
    columns: MediaColumns<T>,
    extent: Extent,
}

/// Takes the media of a map, pixel by pixel.
#[derive(Debug)]
pub(crate) struct TracedMediaBuilder<T> {
    size: [u32; 2],
    /// Number of pixels so far, and of those before the first row that holds something.
    pixels: usize,
    skipped: usize,
    columns: MediaColumns<T>,
    list: Vec<(f32, T)>,
    extent: Extent,
}

impl<T: Transmittance> TracedMediaBuilder<T> {
    /// A builder for a map of `size` pixels.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        let extent = Extent { low: size, high: [0; 2], w: [f64::INFINITY, f64::NEG_INFINITY] };
        let columns = MediaColumns::new();
        Self { size, pixels: 0, skipped: 0, columns, list: Vec::new(), extent }
    }

    /// Takes the borders of the next pixel, row by row, each with the thickness before it.
    pub(crate) fn push_pixel(&mut self, borders: impl Iterator<Item = (f32, T)>) -> Result<()> {
        let width = self.size[0] as usize;
        let at = [self.pixels % width, self.pixels / width];
        self.pixels += 1;
        self.list.clear();
        for (depth, thickness) in borders {
            if let Some((before, extinction)) = self.list.last_mut() {
                let length = depth - *before;
                *extinction =
                    T::from_channels(|channel| (thickness.channel(channel) / length).min(f32::MAX));
            }
            self.list.push((depth, T::splat(0.0)));
        }
        if let [(near, _), .., (far, _)] = self.list[..] {
            let Extent { low, high, w } = &mut self.extent;
            for axis in 0..2 {
                let at = at[axis] as u32;
                (low[axis], high[axis]) = (low[axis].min(at), high[axis].max(at + 1));
            }
            let [least, most] = [far, near].map(|depth| f64::from(depth).recip());
            *w = [w[0].min(least), w[1].max(most)];
        }
        if self.columns.is_empty() {
            if self.list.is_empty() {
                return Ok(());
            }
            self.skipped = at[1] * width;
            self.columns = MediaColumns::clear(at[0]);
        }
        self.columns.push_pixel(self.list.drain(..))
    }

    /// All of them; None if there is nothing.
    pub(crate) fn finish(self) -> Option<TracedMedia<T>> {
        let Self { size, skipped, columns, extent, .. } = self;
        let width = size[0] as usize;
        (!columns.is_empty()).then_some(TracedMedia { width, skipped, columns, extent })
    }
}

impl<T: Transmittance> TracedMedia<T> {
    /// Those of a map of `size` pixels. O(pixels + borders).
    pub(crate) fn new(size: [u32; 2], media: &MediaColumns<T>) -> Result<Option<Self>> {
        if media.is_empty() {
            return Ok(None);
        }
        let mut builder = TracedMediaBuilder::new(size);
        for pixel in 0..media.offsets.len() - 1 {
            builder.push_pixel(media.pixel(pixel))?;
        }
        Ok(builder.finish())
    }

    /// The least and the greatest w of all media.
    pub(crate) fn range(&self) -> [f32; 2] {
        let [least, most] = self.extent.w.map(|w| w as f32);
        [least.next_down(), most.next_up()]
    }

    /// What is left, for each channel, of the light of the rays of `packet` in `some`, which
    /// come from `lights`; other lanes keep 1.
    ///
    /// A ray passes as much of a slab as it is deep in it, stretched by how far it goes for
    /// each unit of depth. It begins at its receiver: what that lies in counts from there.
    #[inline(always)]
    pub(crate) fn left<S: Simd>(
        &self,
        simd: S,
        (frame, apex): (&LightFrame, &Apex),
        (packet, lights): (&Packet, &[DVec3]),
        some: u32,
    ) -> [f32x16<S>; 3] {
        let mut depths = [[0.0; LANES]; 3];
        let w = apex.point.z.recip();
        for lane in bits(some) {
            let Some(&light) = lights.get(lane) else { break };
            let ray = MediaRay {
                corner: apex.corner.map(f64::from),
                within: apex.within.map(f64::from),
                w,
                slope: [0, 1].map(|axis| f64::from(packet.slope[axis][lane])),
                end: packet.end[lane].into(),
            };
            let away = frame.camera_point(light) - apex.point;
            let sum = self.optical_depth(&ray, away.length() / away.z.abs());
            for (channel, depth) in sum.as_ref().iter().enumerate() {
                depths[channel][lane] = depth.min(DARK) as f32;
            }
        }
        depths.map(|depths| exponential(simd, f32x16::load_array(simd, depths)))
    }

    /// The optical depth along a ray of this stretch, or at least [`DARK`].
    #[inline(always)]
    fn optical_depth(&self, ray: &MediaRay, stretch: f64) -> T::Sum {
        let mut sum = T::splat(0.0).to_sum();
        let enough = DARK / stretch;
        let MediaColumns { offsets, depths, thickness: extinctions } = &self.columns;
        ray.walk(&self.extent, |[x, y], [enter, leave]| {
            let pixel = y as usize * self.width + x as usize - self.skipped;
            let (start, end) = (offsets[pixel] as usize, offsets[pixel + 1] as usize);
            if start == end {
                return true;
            }
            // From the far end to the near one.
            let [mut far, near] = [enter, leave].map(f64::recip);
            let borders = &depths[start..end];
            let mut behind = borders.partition_point(|&border| f64::from(border) < far);
            while let Some(at) = behind.checked_sub(1) {
                let border = f64::from(borders[at]);
                let deep = far - border.max(near);
                let extinction = extinctions[start + at];
                for (channel, sum) in sum.as_mut().iter_mut().enumerate() {
                    *sum += f64::from(extinction.channel(channel)) * deep;
                }
                if border <= near {
                    break;
                }
                (far, behind) = (border, at);
            }
            !sum.as_ref().iter().all(|&depth| depth >= enough)
        });
        T::sum_from_channels(|channel| sum.as_ref()[channel] * stretch)
    }
}
