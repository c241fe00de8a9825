//! Percentage closer filtering of a plain shadow map (Reeves, Salesin & Cook
//! 1987; Lokovic & Veach 2000, §2).

use std::sync::Arc;

use dsm_core::detail::Result;
use dsm_core::detail::random::mix32;
use dsm_core::{AreaLight, Error, LightVisibility, Receiver};
use fearless_simd::{Level, dispatch};
use glam::DVec3;

use super::depth_map::DepthMap;
use super::strata::Strata;
use super::tap_region::TapRegion;

/// Draws depths from a filter region and answers the share of them that lies
/// behind the receiver.
///
/// The region is a square, as far as it lies in the map. It is cut into as many
/// equal strata as there are taps, and one texel is drawn from each, at a place
/// hashed from the seed alone. The error of one answer is at most about 0.5/√N
/// for N taps, and less where few of the strata are crossed by an edge (§2).
///
/// ```
/// use dsm_core::Receiver;
/// use shadow_maps::plain::{DepthMap, PercentageCloserFilter};
///
/// // The left half is blocked at depth 1.
/// let depths = (0..64).map(|texel| if texel % 8 < 4 { 1.0 } else { f32::INFINITY }).collect();
/// let map = DepthMap::new([8, 8], [8, 8], depths, None)?;
/// let filter = PercentageCloserFilter::new(map, 64)?.with_width(4.0)?;
/// let light = |x| filter.lookup(&Receiver::new([x, 4.0], 2.0), 7);
/// assert_eq!([light(2.0), light(4.0), light(6.0)], [0.0, 0.5, 1.0]);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct PercentageCloserFilter {
    map: Arc<DepthMap>,
    strata: Strata,
    width: f32,
    bias: f32,
    level: Level,
}

impl PercentageCloserFilter {
    /// The most taps of a lookup.
    pub const MAX_TAPS: u32 = 4096;

    /// A filter of `taps` taps over regions one pixel of the map wide, without
    /// bias.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless the taps are a square number up to
    /// [`Self::MAX_TAPS`].
    pub fn new(map: impl Into<Arc<DepthMap>>, taps: u32) -> Result<Self> {
        let side = taps.isqrt();
        if taps == 0 || taps > Self::MAX_TAPS || side * side != taps {
            let reason = "there must be a square number of them, 1 to 4096";
            return Err(Error::Setting { setting: "taps", reason });
        }
        let map = map.into();
        Ok(Self { map, strata: Strata::new(side), width: 1.0, bias: 0.0, level: Level::new() })
    }

    /// Sets the filter width: regions of `width` × `width` pixels of the map.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless it is finite and above 0.
    pub fn with_width(self, width: f32) -> Result<Self> {
        if width > 0.0 && width < f32::INFINITY {
            Ok(Self { width, ..self })
        } else {
            let reason = "a filter region has a finite width above 0";
            Err(Error::Setting { setting: "width", reason })
        }
    }

    /// Sets the depth bias of receivers in the world, in scene units.
    #[must_use]
    pub const fn with_bias(mut self, bias: f32) -> Self {
        self.bias = bias;
        self
    }

    /// The map.
    #[must_use]
    pub const fn map(&self) -> &Arc<DepthMap> {
        &self.map
    }

    /// Taps of a lookup.
    #[must_use]
    pub const fn taps(&self) -> u32 {
        self.strata.count()
    }

    /// The share of light that reaches `receiver`, whose raster position and
    /// gradient count pixels of the map. What lies at the receiver's very depth
    /// shades it, as in a deep map. A receiver outside the map, at a depth ≤ 0
    /// or with a NaN is lit: 1. O(taps).
    #[must_use]
    pub fn lookup(&self, receiver: &Receiver, seed: u64) -> f32 {
        self.lookup_over(receiver, [self.width; 2], seed)
    }

    /// Visibility over a region of `widths` pixels of the map across and down,
    /// for methods whose filter depends on the receiver. What is not above 0,
    /// or NaN, reads a single texel.
    #[must_use]
    pub fn lookup_over(&self, receiver: &Receiver, widths: [f32; 2], seed: u64) -> f32 {
        let Some((region, plane)) = TapRegion::around(&self.map, receiver, widths) else {
            return 1.0;
        };
        let seed = mix32(seed as u32 ^ mix32((seed >> 32) as u32));
        let depths = self.map.depths();
        let strata = &self.strata;
        let lit = dispatch!(self.level, simd => strata.lit(simd, depths, &region, &plane, seed));
        lit as f32 / strata.count() as f32
    }

    /// The result of [`Self::lookup`], one tap after the other: the baseline of
    /// tests and timings of the vectors.
    #[must_use]
    pub fn lookup_scalar(&self, receiver: &Receiver, seed: u64) -> f32 {
        let Some((region, plane)) = TapRegion::around(&self.map, receiver, [self.width; 2]) else {
            return 1.0;
        };
        let seed = mix32(seed as u32 ^ mix32((seed >> 32) as u32));
        let lit = self.strata.lit_scalar(self.map.depths(), &region, &plane, seed);
        lit as f32 / self.strata.count() as f32
    }
}

impl LightVisibility for PercentageCloserFilter {
    type Value = f32;
    type Error = Error;

    /// The lookup at the receiver's place in the map. The light is where the
    /// map's camera stands; its extent is what the filter's width stands for.
    /// A receiver that the camera does not see is lit.
    ///
    /// # Errors
    ///
    /// [`Error::Camera`] if the map's is unknown.
    fn visibility(&self, receiver: DVec3, _light: &AreaLight, seed: u64) -> Result<f32> {
        let camera = self.map.camera().ok_or(Error::Camera("the map's is unknown"))?;
        let Some(projected) = camera.project(receiver)? else { return Ok(1.0) };
        let [width, height] = self.map.size().map(f64::from);
        let position = [(projected.x * width) as f32, (projected.y * height) as f32];
        let bias = self.bias;
        let receiver = Receiver { bias, ..Receiver::new(position, projected.z as f32) };
        Ok(self.lookup(&receiver, seed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dsm_core::ShadowCamera;
    use dsm_testkit::config;
    use glam::{DMat4, DVec3, DVec4};
    use proptest::collection::vec;
    use proptest::prelude::*;
    use proptest::sample::select;

    /// A map of 6 × 5 pixels with few depths, so that receivers meet them.
    fn maps() -> impl Strategy<Value = DepthMap> {
        (1_u32..4).prop_flat_map(|side| {
            let texels = [6 * side, 5 * side];
            let depth = select(vec![0.5, 1.0, 2.0, f32::INFINITY]);
            let depths = vec(depth, (texels[0] * texels[1]) as usize);
            depths.prop_map(move |depths| DepthMap::new([6, 5], texels, depths, None).unwrap())
        })
    }

    fn receivers() -> impl Strategy<Value = Receiver> {
        let position = prop_oneof![(0_u8..13).prop_map(|half| f32::from(half) * 0.5), 0.0_f32..6.0];
        let depth = select(vec![0.25, 0.5, 1.0, 1.5, 2.0, 3.0]);
        let slope = select(vec![0.0, 0.0, 0.125, -0.25]);
        ([position.clone(), position], depth, [slope.clone(), slope], select(vec![0.0, 0.25]))
            .prop_map(|(position, depth, depth_gradient, bias)| Receiver {
                position,
                depth,
                bias,
                depth_gradient,
            })
    }

    fn widths() -> impl Strategy<Value = f32> {
        prop_oneof![select(vec![0.5, 1.0, 1.5, 2.0, 4.0, 20.0]), 0.01_f32..8.0]
    }

    /// How many strata must be lit, and how many may be, by the area of each
    /// that lies over lit texels.
    fn bounds(map: &DepthMap, receiver: &Receiver, width: f64, side: u32) -> [u32; 2] {
        let [columns, rows] = map.texels();
        let per_pixel = f64::from(map.texels_per_side());
        let edge = |axis: usize, sign: f64| {
            let size = f64::from(map.size()[axis]);
            (f64::from(receiver.position[axis]) + sign * 0.5 * width).clamp(0.0, size) * per_pixel
        };
        let (start, end) = ([edge(0, -1.0), edge(1, -1.0)], [edge(0, 1.0), edge(1, 1.0)]);
        let z = receiver.depth - receiver.bias;
        let mut bounds = [0, 0];
        for cell in 0..side * side {
            let cell = [cell % side, cell / side];
            let at = |axis: usize, part: u32| {
                start[axis] + (end[axis] - start[axis]) * f64::from(part) / f64::from(side)
            };
            let overlap = |axis: usize, texel: u32| {
                let low = at(axis, cell[axis]).max(f64::from(texel));
                (at(axis, cell[axis] + 1).min(f64::from(texel + 1)) - low).max(0.0)
            };
            let (mut lit, mut all) = (0.0, 0.0);
            for y in 0..rows {
                for x in 0..columns {
                    let area = overlap(0, x) * overlap(1, y);
                    all += area;
                    lit += if map.depth(x, y) > z { area } else { 0.0 };
                }
            }
            bounds[0] += u32::from(lit > 0.999 * all);
            bounds[1] += u32::from(lit > 0.001 * all);
        }
        bounds
    }

    proptest! {
        #![proptest_config(config(0x5043_4631))]

        #[test]
        fn vectors_answer_as_single_taps(
            (map, receiver, width) in (maps(), receivers(), widths()),
            side in 1_u32..10,
            seed in any::<u64>(),
        ) {
            let filter = PercentageCloserFilter::new(map, side * side).unwrap();
            let filter = filter.with_width(width).unwrap();
            let light = filter.lookup(&receiver, seed);
            prop_assert_eq!(light, filter.lookup_scalar(&receiver, seed));
            prop_assert!((0.0..=1.0).contains(&light));
            let deeper = Receiver { depth: receiver.depth + 0.5, ..receiver };
            prop_assert!(filter.lookup(&deeper, seed) <= light);
        }

        #[test]
        fn every_stratum_has_a_tap_of_its_own(
            (map, receiver, width) in (maps(), receivers(), widths()),
            side in 1_u32..9,
            seed in any::<u64>(),
        ) {
            let receiver = Receiver { depth_gradient: [0.0; 2], ..receiver };
            let inside = receiver.position[0] < 6.0 && receiver.position[1] < 5.0;
            prop_assume!(inside && receiver.depth > receiver.bias);
            let filter = PercentageCloserFilter::new(map.clone(), side * side).unwrap();
            let light = filter.with_width(width).unwrap().lookup(&receiver, seed);
            let lit = (light * (side * side) as f32).round() as u32;
            let [least, most] = bounds(&map, &receiver, width.into(), side);
            prop_assert!((least..=most).contains(&lit), "{lit} of {least} to {most}");
        }
    }

    #[test]
    fn the_mean_is_the_area() {
        // A diagonal edge, which no stratum follows.
        let depths = (0..256).map(|at| if at % 16 > at / 16 { 1.0 } else { f32::INFINITY });
        let map = DepthMap::new([8, 8], [16, 16], depths.collect(), None).unwrap();
        let filter = PercentageCloserFilter::new(map, 16).unwrap().with_width(3.0).unwrap();
        let receiver = Receiver::new([3.75, 4.25], 2.0);
        let count = 4000;
        let lights: Vec<f64> = (0..count).map(|s| filter.lookup(&receiver, s).into()).collect();
        let mean = lights.iter().sum::<f64>() / count as f64;
        // Counted in quarters of texels.
        let region = |centre: f64| ((centre - 1.5) * 8.0) as i32..((centre + 1.5) * 8.0) as i32;
        let cells = region(4.25).flat_map(|y| region(3.75).map(move |x| [x / 4, y / 4]));
        let lit = cells.clone().filter(|[x, y]| x <= y).count() as f64;
        let area = lit / cells.count() as f64;
        assert!((mean - area).abs() < 4.0 * 0.125 / (count as f64).sqrt(), "{mean} {area}");
        assert!(lights.iter().any(|&light| light != lights[0]));
    }

    #[test]
    fn receivers_ask_along_their_plane() {
        // Texel i is 1.5 + i / 4 deep; the plane rises as fast, half a texel on.
        let depths = (0..64).map(|texel| 0.25 * (texel % 8) as f32 + 1.5);
        let map = DepthMap::new([8, 8], [8, 8], depths.collect(), None).unwrap();
        let filter = PercentageCloserFilter::new(map, 256).unwrap().with_width(4.0).unwrap();
        let flat = Receiver::new([4.0, 4.0], 2.5);
        assert_eq!(filter.lookup(&flat, 3), 0.25);
        let along = |depth| {
            let receiver =
                Receiver { depth_gradient: [0.25, 0.0], ..Receiver::new([4.0, 4.0], depth) };
            filter.lookup(&receiver, 3)
        };
        assert_eq!([along(2.0), along(3.0)], [1.0, 0.0]);
    }

    #[test]
    fn nowhere_is_lit() {
        let map = DepthMap::new([2, 2], [2, 2], vec![1.0; 4], None).unwrap();
        let filter = PercentageCloserFilter::new(map.clone(), 4).unwrap();
        let shaded = Receiver::new([1.0, 1.0], 2.0);
        assert_eq!(filter.lookup(&shaded, 0), 0.0);
        let nan = f32::NAN;
        for receiver in [
            Receiver { position: [-0.1, 1.0], ..shaded },
            Receiver { position: [1.0, 2.0], ..shaded },
            Receiver { position: [nan, 1.0], ..shaded },
            Receiver { depth: nan, ..shaded },
            Receiver { depth: 0.0, ..shaded },
            Receiver { bias: nan, ..shaded },
            Receiver { depth_gradient: [0.0, nan], ..shaded },
        ] {
            assert_eq!(filter.lookup(&receiver, 0), 1.0, "{receiver:?}");
        }
        for widths in [[0.0; 2], [nan; 2], [-1.0, f32::INFINITY], [1e-30, f32::MAX]] {
            assert_eq!(filter.lookup_over(&shaded, widths, 0), 0.0);
        }
        assert!(PercentageCloserFilter::new(map.clone(), 0).is_err());
        assert!(PercentageCloserFilter::new(map.clone(), 8).is_err());
        assert!(PercentageCloserFilter::new(map, 65 * 65).is_err());
        for width in [0.0, -1.0, nan, f32::INFINITY] {
            assert!(filter.clone().with_width(width).is_err());
        }
    }

    #[test]
    fn receivers_of_the_world_are_projected() {
        // At (0, 0, 5), looking down −z, 90 degrees wide.
        let view = DMat4::from_translation(DVec3::new(0.0, 0.0, -5.0));
        let projection = DMat4::from_rows(
            DVec4::new(0.5, 0.0, -0.5, 0.0),
            DVec4::new(0.0, -0.5, -0.5, 0.0),
            DVec4::Z,
            DVec4::new(0.0, 0.0, -1.0, 0.0),
        );
        let camera =
            ShadowCamera { world_to_camera: Some(view), world_to_ndc: Some(projection * view) };
        // The upper right quarter is blocked at depth 4.
        let depth = |at: i32| if at % 4 < 2 || at >= 8 { f32::INFINITY } else { 4.0 };
        let depths: Vec<f32> = (0..16).map(depth).collect();
        let map = DepthMap::new([4, 4], [4, 4], depths.clone(), Some(camera)).unwrap();
        let filter = PercentageCloserFilter::new(map, 4).unwrap().with_bias(0.25);
        let light = AreaLight::point(DVec3::Z * 5.0);
        let factor = |x, y, z| filter.visibility(DVec3::new(x, y, z), &light, 1);
        assert_eq!(factor(-2.0, 1.5, 0.0), Ok(1.0));
        assert_eq!(factor(2.0, -1.5, 0.0), Ok(1.0));
        assert_eq!(factor(2.0, 1.5, 0.0), Ok(0.0));
        assert_eq!(factor(2.0, 1.5, 0.5), Ok(0.0));
        assert_eq!(factor(2.0, 1.5, 0.8), Ok(1.0));
        assert_eq!(factor(2.0, 1.5, 6.0), Ok(1.0));
        assert_eq!(factor(f64::NAN, 0.0, 0.0), Ok(1.0));
        let nowhere = DepthMap::new([4, 4], [4, 4], depths, None).unwrap();
        let filter = PercentageCloserFilter::new(nowhere.clone(), 4).unwrap();
        assert!(filter.visibility(DVec3::ZERO, &light, 1).is_err());
    }
}
