//! Trials of far tables.

use dsm_core::detail::random::golden;
use dsm_core::{AreaLight, Facing, ShadedPoint, Transmittance};
use dsm_trace::detail::TraceCounters;
use glam::DVec3;

use super::fragment::Fragment;
use super::tracer::{FragmentTracer, TraceScratch};

/// Receivers of either kind that a far table is tried on.
const CHECKS: usize = 64;

/// How far off a far table may be in the mean of a kind of receivers, and at its
/// root mean square: between what hair and leaves show (0.001 and 0.007) and a
/// closed mesh does (0.004 and 0.011).
const MEAN_OFF: f64 = 0.003;
const ROOT_OFF: f64 = 0.0095;

impl<T: Transmittance> FragmentTracer<T> {
    /// Sets a far table ([`Self::with_far_table`]) beyond one coarse pixel if it does as
    /// well as fragments all the way for `light`, 64 receivers on fragments and 64 on the
    /// farthest of their pixels: in their means within 0.003, and at their root mean
    /// square within 0.0095.
    #[must_use]
    pub fn for_light(self, light: &AreaLight) -> Self {
        let mut exact = self;
        exact.far = None;
        // What media take is the same with it and without.
        let media = exact.media.take();
        let receivers = exact.check_receivers();
        let means = |tracer: &Self| -> Vec<f64> {
            let check = (0..).zip(&receivers).map(|(seed, &position)| {
                let mut scratch = TraceScratch::default();
                let point = ShadedPoint { position, facing: Facing::Light, seed };
                let mean = tracer.visibility_with(&point, light, &mut scratch).to_sum();
                mean.as_ref().iter().sum::<f64>() / T::CHANNELS as f64
            });
            check.collect()
        };
        let truth = means(&exact);
        let mut mixed = exact.with_far_table(Self::NEAR_CELLS);
        if mixed.far.is_none() {
            mixed.media = media;
            mixed.counters = TraceCounters::default();
            return mixed;
        }
        let differences: Vec<f64> =
            means(&mixed).iter().zip(&truth).map(|(have, want)| have - want).collect();
        let alike = differences.chunks(CHECKS).all(|some| {
            let count = some.len() as f64;
            let mean = some.iter().sum::<f64>() / count;
            let square = some.iter().map(|off| off * off).sum::<f64>() / count;
            mean.abs() <= MEAN_OFF && square.sqrt() <= ROOT_OFF
        });
        mixed.far = mixed.far.filter(|_| alike && !differences.is_empty());
        mixed.counters = TraceCounters::default();
        mixed.media = media;
        mixed
    }

    /// Points on fragments, seen from the light, and as many on the farthest ones
    /// of their pixels, where shadows fall.
    fn check_receivers(&self) -> Vec<DVec3> {
        let count = self.count;
        if count == 0 {
            return Vec::new();
        }
        // Spread over the fragments by the golden ratio, in no step that rows could
        // have, too.
        let share = |index: usize| golden(0.0, index as f64);
        let wanted: Vec<usize> = (0..CHECKS)
            .map(|index| ((share(index) * count as f64) as usize).min(count - 1))
            .collect();
        let point = |[x, y]: [u32; 2], fragment: Fragment<T>| {
            let [low, high] = fragment.range().map(f64::from);
            let depth = ((low + high) / 2.0).max(f64::MIN_POSITIVE).recip();
            // A little towards the light.
            let [x, y] = [x, y].map(|side| f64::from(side) + 0.5);
            self.frame.unproject(x, y, depth * 0.9995)
        };
        let found = self.pixels_of(&wanted).into_iter().map(|(pixel, within)| {
            let mut fragments = self.fragments.pixel::<T>(pixel);
            let farthest = fragments.next()?;
            let own = if within == 0 { farthest } else { fragments.nth(within - 1)? };
            Some([own, farthest].map(|fragment| point(pixel, fragment)))
        });
        let some: Vec<[DVec3; 2]> = found.flatten().collect();
        let of = |kind: usize| some.iter().map(move |points| points[kind]);
        of(0).chain(of(1)).collect()
    }

    /// The pixels that hold the fragments of these numbers, counted pixel by pixel and
    /// row by row, and which of its own each is.
    fn pixels_of(&self, wanted: &[usize]) -> Vec<([u32; 2], usize)> {
        let [width, height] = self.frame.size();
        let mut counts = vec![0_u32; width as usize * height as usize];
        self.fragments.for_each::<T>(|[x, y], _| {
            counts[y as usize * width as usize + x as usize] += 1;
        });
        let mut first = 0;
        let starts: Vec<usize> = counts
            .iter()
            .map(|&count| {
                first += count as usize;
                first - count as usize
            })
            .collect();
        let pixel = |&at: &usize| {
            let pixel = starts.partition_point(|&start| start <= at) - 1;
            // Of pixels that begin there, the last holds it.
            let place = [pixel as u32 % width, pixel as u32 / width];
            (place, at - starts[pixel])
        };
        wanted.iter().map(pixel).collect()
    }
}
