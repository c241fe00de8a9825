//! The rays of a packet on their way.

use dsm_core::Transmittance;
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16, mask32x16, u32x16};

use super::lane_count::LANES;
use super::packet::Packet;

/// The rays of a packet on their way, and what is left of their light. In
/// memory, so that they can be asked together and one by one.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes {
    pub(crate) slope: [[f32; LANES]; 2],
    /// 1 / slope, for tests of where a ray may be; never of 0.
    pub(crate) inverse: [[f32; LANES]; 2],
    pub(crate) start: [[f32; LANES]; 2],
    pub(crate) end: [f32; LANES],
    /// Where rays may meet something, with room for rounding.
    pub(crate) near: [f32; LANES],
    pub(crate) far: [f32; LANES],
    /// Light that is left, a channel each.
    pub(crate) left: [[f32; LANES]; 3],
    /// Bits of the rays that have not ended.
    pub(crate) live: u32,
}

impl Lanes {
    /// The rays of `packet` up to `cut`, all of their light left.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(simd: S, packet: &Packet, cut: f32) -> Self {
        let load = |column: &[f32; LANES]| f32x16::load_array_ref(simd, column);
        let end = load(&packet.end).min(f32x16::splat(simd, cut));
        let near = load(&packet.start[0]).min(load(&packet.start[1]));
        let slack = packet.cone.slack();
        let inverse = [0, 1].map(|axis| {
            let slope = load(&packet.slope[axis]);
            let least = f32x16::splat(simd, packet.cone.least_slope());
            let small = slope.abs().simd_lt(least);
            (f32x16::splat(simd, 1.0) / small.select(least, slope)).to_array()
        });
        Self {
            slope: packet.slope,
            inverse,
            start: packet.start,
            end: end.to_array(),
            near: (near - slack).to_array(),
            far: (end + slack).to_array(),
            left: [[1.0; LANES]; 3],
            live: end.simd_gt(f32x16::splat(simd, 0.0)).to_bitmask() as u32,
        }
    }

    /// Lets the rays that have not ended go on from `cut`, to the ends of `packet`.
    #[inline(always)]
    pub(crate) fn go_on<S: Simd>(&mut self, simd: S, packet: &Packet, cut: f32) {
        let (left, live) = (self.left, self.live);
        let start = packet.start.map(|column| {
            f32x16::load_array_ref(simd, &column).max(f32x16::splat(simd, cut)).to_array()
        });
        let rest = Self::new(simd, &Packet { start, ..*packet }, f32::INFINITY);
        *self = Self { left, live, ..rest };
        for lane in (0..LANES).filter(|lane| live >> lane & 1 == 0) {
            [self.end[lane], self.far[lane]] = [-1.0; 2];
        }
    }

    /// Which rays meet a fragment of the pixel that lies `step` pixels before the apex's
    /// own, `within` which that is: `distance` is how much more w its plane has at the apex
    /// than it.
    ///
    /// Where a ray is, is told from the apex's own pixel for all of them, so that it
    /// passes between no two.
    ///
    /// No product is fused with a sum: all processors round alike.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(
        &self,
        simd: S,
        (step, within): ([f32; 2], [f32; 2]),
        distance: f32,
        gradient: [f32; 2],
        facing: bool,
        coverage: impl FnOnce() -> u64,
    ) -> mask32x16<S> {
        let splat = |value| f32x16::splat(simd, value);
        let load = |column: &[f32; LANES]| f32x16::load_array_ref(simd, column);
        let [along_x, along_y] = [load(&self.slope[0]), load(&self.slope[1])];
        let closing = splat(1.0) - (along_x * gradient[0] + along_y * gradient[1]);
        let u = splat(distance) / closing;
        let x = along_x * u + within[0];
        let y = along_y * u + within[1];
        let within = x.simd_ge(splat(-step[0]))
            & x.simd_lt(splat(1.0 - step[0]))
            & y.simd_ge(splat(-step[1]))
            & y.simd_lt(splat(1.0 - step[1]));
        let start = load(&self.start[usize::from(facing)]);
        let met = within & u.simd_ge(start) & u.simd_lt(load(&self.end));
        if met.to_bitmask() == 0 {
            return met;
        }
        let coverage = coverage();
        if coverage == u64::MAX {
            return met;
        }
        // In eighths of the pixel, of which the last may round to the next pixel.
        let last = splat(7.0);
        let x: u32x16<S> = ((x + step[0]) * 8.0).min(last).to_int();
        let y: u32x16<S> = ((y + step[1]) * 8.0).min(last).to_int();
        let bit = (y << 3) | x;
        let upper = bit.simd_ge(u32x16::splat(simd, 32));
        let (low, high) = (coverage as u32, (coverage >> 32) as u32);
        let word = upper.select(u32x16::splat(simd, high), u32x16::splat(simd, low));
        let covered = (word >> (bit & 31)) & 1;
        met & covered.simd_eq(u32x16::splat(simd, 1))
    }

    /// Which rays meet the plane of [`Self::meet`] within `reach` pixels of the apex.
    #[inline(always)]
    pub(crate) fn is_near<S: Simd>(
        &self,
        simd: S,
        distance: f32,
        gradient: [f32; 2],
        reach: f32,
    ) -> mask32x16<S> {
        let load = |column: &[f32; LANES]| f32x16::load_array_ref(simd, column);
        let [along_x, along_y] = [load(&self.slope[0]), load(&self.slope[1])];
        let closing = f32x16::splat(simd, 1.0) - (along_x * gradient[0] + along_y * gradient[1]);
        let u = f32x16::splat(simd, distance) / closing;
        let reach = f32x16::splat(simd, reach);
        (along_x * u).abs().simd_lt(reach) & (along_y * u).abs().simd_lt(reach)
    }

    /// Takes the share `opacity` of each channel from the light of the rays in `met`.
    #[inline(always)]
    pub(crate) fn take<S: Simd, T: Transmittance>(
        &mut self,
        simd: S,
        met: mask32x16<S>,
        opacity: impl Fn(usize) -> f32,
    ) {
        for channel in 0..T::CHANNELS {
            let left = f32x16::load_array_ref(simd, &self.left[channel]);
            self.left[channel] = met.select(left * (1.0 - opacity(channel)), left).to_array();
        }
    }

    /// The same of the rays with a bit set.
    pub(crate) fn take_some<T: Transmittance>(&mut self, some: u32, opacity: T) {
        for lane in (0..LANES).filter(|lane| some >> lane & 1 == 1) {
            self.take_alone::<T>(lane, |channel| opacity.channel(channel));
        }
    }

    /// The same of one ray.
    #[inline(always)]
    pub(crate) fn take_alone<T: Transmittance>(
        &mut self,
        lane: usize,
        opacity: impl Fn(usize) -> f32,
    ) {
        for channel in 0..T::CHANNELS {
            self.left[channel][lane] *= 1.0 - opacity(channel);
        }
    }

    /// Puts out the light that fell below `least` in every channel, and ends
    /// those rays.
    #[inline(always)]
    pub(crate) fn stop<S: Simd, T: Transmittance>(&mut self, simd: S, least: f32) {
        let limit = f32x16::splat(simd, least);
        let load = |column: &[f32; LANES]| f32x16::load_array_ref(simd, column);
        let mut dark = load(&self.left[0]).simd_lt(limit);
        for channel in 1..T::CHANNELS {
            dark &= load(&self.left[channel]).simd_lt(limit);
        }
        if dark.to_bitmask() as u32 & self.live == 0 {
            return;
        }
        self.live &= !(dark.to_bitmask() as u32);
        let zero = f32x16::splat(simd, 0.0);
        for channel in 0..T::CHANNELS {
            let left = load(&self.left[channel]);
            self.left[channel] = dark.select(zero, left).to_array();
        }
        self.end = dark.select(f32x16::splat(simd, -1.0), load(&self.end)).to_array();
    }

    /// The same of one ray. Tells whether it has ended.
    #[inline(always)]
    pub(crate) fn stop_alone<T: Transmittance>(&mut self, lane: usize, least: f32) -> bool {
        let dark = self.left[..T::CHANNELS].iter().all(|left| left[lane] < least);
        if dark {
            self.left.iter_mut().for_each(|left| left[lane] = 0.0);
            self.end[lane] = -1.0;
            self.live &= !(1 << lane);
        }
        dark
    }
}
