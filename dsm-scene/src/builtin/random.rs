//! Pseudo-random numbers of the built-in scenes.

use dsm_core::detail::random::EMPTY_HASH;
use dsm_core::detail::random::{combine, unit};
use glam::{DVec3, IVec3};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// A seeded sequence of numbers.
pub(super) struct Random(Pcg32);

impl Random {
    /// The sequence of `seed`.
    pub(super) fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 0xda3e_39cb_94b9_5bdb))
    }

    /// Even in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / 2.0_f64.powi(32)
    }

    /// Even in [−1, 1).
    pub(super) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Even in [`from`, `to`).
    pub(super) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Below `count`, which is not 0.
    pub(super) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    /// Even in the unit ball, except for its very centre.
    pub(super) fn in_ball(&mut self) -> DVec3 {
        loop {
            let point = DVec3::new(self.signed(), self.signed(), self.signed());
            if (1e-6..=1.0).contains(&point.length_squared()) {
                return point;
            }
        }
    }

    /// Even over the unit sphere.
    pub(super) fn direction(&mut self) -> DVec3 {
        let point = self.in_ball();
        point / point.length()
    }

    /// Roughly normal in every coordinate, of deviation 1.
    pub(super) fn normal(&mut self) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for _ in 0..4 {
            sum += DVec3::new(self.signed(), self.signed(), self.signed());
        }
        sum * 0.75_f64.sqrt()
    }
}

/// Two directions across a unit vector and across each other.
pub(super) fn across(direction: DVec3, random: &mut Random) -> [DVec3; 2] {
    loop {
        let other = direction.cross(random.direction());
        if other.length_squared() > 1e-4 {
            let first = other / other.length();
            return [first, direction.cross(first)];
        }
    }
}

/// Noise in [0, 1]: random at whole numbers, smooth between them.
pub(super) fn noise(point: DVec3) -> f64 {
    let cell = point.floor();
    let part = point - cell;
    let smooth = part * part * (3.0 - 2.0 * part);
    let cell = cell.as_ivec3();
    let mix = |a: f64, b: f64, part: f64| a + (b - a) * part;
    let at = |x, y, z| lattice(cell + IVec3::new(x, y, z));
    let edge = |y, z| mix(at(0, y, z), at(1, y, z), smooth.x);
    let side = |z| mix(edge(0, z), edge(1, z), smooth.y);
    mix(side(0), side(1), smooth.z)
}

/// Noise at several scales, in [0, 1).
pub(super) fn fractal_noise(point: DVec3, octaves: i32) -> f64 {
    let octave = |index: i32| {
        let scale = f64::from(1 << index);
        noise(point * scale + DVec3::splat(17.0 * f64::from(index))) / (2.0 * scale)
    };
    (0..octaves).map(octave).sum()
}

fn lattice(index: IVec3) -> f64 {
    let parts = index.to_array().into_iter().map(|part| u64::from(part as u32));
    unit(parts.fold(EMPTY_HASH, combine))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_these_on_every_platform() {
        let mut random = Random::new(1);
        let numbers = [random.unit(), random.unit(), random.unit()];
        assert_eq!(numbers.map(|number| (number * 2.0_f64.powi(32)) as u32), PCG32_OF_1);
        assert_eq!(noise(DVec3::ZERO), lattice(IVec3::ZERO));
    }

    const PCG32_OF_1: [u32; 3] = [4_033_076_299, 2_971_934_609, 4_165_137_090];

    #[test]
    fn noise_is_smooth_and_in_range() {
        let mut random = Random::new(2);
        let (mut low, mut high) = (1.0_f64, 0.0_f64);
        for _ in 0..2000 {
            let point = random.in_ball() * 50.0;
            let value = noise(point);
            low = low.min(value);
            high = high.max(value);
            assert!((noise(point + DVec3::splat(1e-6)) - value).abs() < 1e-5);
            assert!((0.0..1.0).contains(&fractal_noise(point, 4)));
        }
        assert!((0.0..0.2).contains(&low) && (0.8..=1.0).contains(&high), "{low} {high}");
    }

    #[test]
    fn directions_are_even() {
        let mut random = Random::new(3);
        let mut sum = DVec3::ZERO;
        let mut squares = DVec3::ZERO;
        for _ in 0..10_000 {
            let direction = random.direction();
            assert!((direction.length() - 1.0).abs() < 1e-12);
            sum += direction;
            squares += direction * direction;
            let [a, b] = across(direction, &mut random);
            assert!(direction.dot(a).abs() < 1e-12 && a.dot(b).abs() < 1e-12);
        }
        assert!((sum / 10_000.0).abs().max_element() < 0.02);
        assert!((squares / 10_000.0 - 1.0 / 3.0).abs().max_element() < 0.02);
    }
}
