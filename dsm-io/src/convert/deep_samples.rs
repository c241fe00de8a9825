//! Deep samples as what a ray meets: T(z) = ∏ (1 − aᵢ(z)) whatever their
//! order.

use deep_exr::detail::Alpha;
use deep_exr::{DeepRows, DeepSample};
use dsm_core::{RayHits, SurfaceHit, Transmittance};

use super::report::ImportReport;
use crate::error::Result;

/// Adds what the ray through `pixel` meets to `hits`.
pub(super) fn collect_hits<T: Transmittance>(
    rows: &DeepRows,
    pixel: usize,
    hits: &mut RayHits<T>,
    report: &mut ImportReport,
) -> Result<()> {
    report.opaque_without_alpha |= matches!(rows.alpha(), Alpha::Opaque);
    rows.pixel(pixel).try_for_each(|index| push_sample(rows.sample(index), hits, report))
}

/// Adds a sample to the ray's hits, cleaned as the report says.
fn push_sample<T: Transmittance>(
    sample: DeepSample,
    hits: &mut RayHits<T>,
    report: &mut ImportReport,
) -> Result<()> {
    report.samples += 1;
    let DeepSample { z, mut z_back, alpha } = sample;
    let alpha = &alpha[..T::CHANNELS];
    if !z.is_finite() {
        report.dropped_not_finite += 1;
        return Ok(());
    }
    if !z_back.is_finite() {
        // Where a volume ends nowhere, its opacity has no place but its front.
        z_back = z;
        report.back_not_finite += 1;
    }
    if z < 0.0 && z_back <= 0.0 {
        report.dropped_behind_camera += 1;
        return Ok(());
    }
    if alpha.iter().any(|alpha| alpha.is_nan()) {
        report.dropped_opacity_nan += 1;
        return Ok(());
    }
    if alpha.iter().any(|alpha| !(0.0..=1.0).contains(alpha)) {
        report.clamped_opacity += 1;
    }
    let opacity = T::from_channels(|channel| alpha[channel].clamp(0.0, 1.0));
    if z_back <= z {
        hits.push_surface(SurfaceHit { depth: z, opacity })?;
    } else if z >= 0.0 {
        hits.push_slab(z, z_back, opacity)?;
    } else {
        report.cut_at_camera += 1;
        hits.push_slab(0.0, z_back, remaining_opacity(opacity, z, z_back))?;
    }
    Ok(())
}

/// The opacity of the part of a volume over [`z`, `z_back`) that lies in front
/// of the camera; `z` is negative.
fn remaining_opacity<T: Transmittance>(opacity: T, z: f32, z_back: f32) -> T {
    let share = f64::from(z_back) / (f64::from(z_back) - f64::from(z));
    T::from_channels(|channel| match f64::from(opacity.channel(channel)) {
        1.0 => 1.0,
        whole => -(share * (-whole).ln_1p()).exp_m1() as f32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dsm_core::Rgb;

    fn hits_of(samples: &[(f32, f32, f32)]) -> (RayHits<f32>, ImportReport) {
        let (mut hits, mut report) = (RayHits::default(), ImportReport::default());
        for &(z, z_back, alpha) in samples {
            push_sample(DeepSample { z, z_back, alpha: [alpha; 3] }, &mut hits, &mut report)
                .unwrap();
        }
        (hits, report)
    }

    #[test]
    fn points_and_volumes_are_told_apart_by_their_back() {
        let (hits, report) = hits_of(&[(2.0, 2.0, 0.5), (3.0, 1.0, 0.25), (4.0, 5.0, 0.5)]);
        assert_eq!(hits.surfaces().len(), 2);
        assert_eq!(hits.segments().len(), 1);
        assert!(report.lines().is_empty());
    }

    #[test]
    fn what_no_ray_can_have_is_dropped_and_counted() {
        let (hits, report) = hits_of(&[
            (f32::NAN, 1.0, 0.5),
            (f32::INFINITY, f32::INFINITY, 0.5),
            (-2.0, -2.0, 0.5),
            (-2.0, 0.0, 0.5),
            (1.0, 1.0, f32::NAN),
        ]);
        assert!(hits.is_empty());
        assert_eq!(report.samples, 5);
        assert_eq!(report.dropped_not_finite, 2);
        assert_eq!(report.dropped_behind_camera, 2);
        assert_eq!(report.dropped_opacity_nan, 1);
    }

    #[test]
    fn a_back_that_is_not_finite_leaves_a_point() {
        let backs = [f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
        let (hits, report) = hits_of(&backs.map(|back| (2.0, back, 0.5)));
        assert!(hits.surfaces().iter().all(|hit| hit.depth == 2.0 && hit.opacity == 0.5));
        assert_eq!((hits.surfaces().len(), hits.segments().len()), (3, 0));
        assert_eq!((report.back_not_finite, report.dropped_not_finite), (3, 0));
        assert_eq!(
            report.lines(),
            ["3 of 3 samples taken as points: the back depth is not finite"]
        );
    }

    #[test]
    fn opacities_are_clamped_and_counted() {
        let (hits, report) = hits_of(&[(1.0, 1.0, 1.5), (2.0, 2.0, -0.5), (3.0, 3.0, 1.0)]);
        let opacities: Vec<f32> = hits.surfaces().iter().map(|hit| hit.opacity).collect();
        assert_eq!(opacities, [1.0, 0.0, 1.0]);
        assert_eq!(report.clamped_opacity, 2);
    }

    #[test]
    fn a_volume_through_the_camera_keeps_what_lies_in_front() {
        let (hits, report) = hits_of(&[(-1.0, 1.0, 0.75)]);
        let segment = hits.segments()[0];
        assert_eq!((segment.near, segment.far, report.cut_at_camera), (0.0, 1.0, 1));
        // Half of the length lets √¼ through.
        assert!((segment.near_extinction[0] - 2_f64.ln()).abs() < 1e-7);
    }

    #[test]
    fn a_nan_in_a_colour_that_mono_maps_lack_is_no_matter() {
        let (mut hits, mut report) = (RayHits::<f32>::default(), ImportReport::default());
        let sample = DeepSample { z: 1.0, z_back: 1.0, alpha: [0.5, f32::NAN, 0.5] };
        push_sample(sample, &mut hits, &mut report).unwrap();
        assert_eq!(hits.surfaces().len(), 1);
        let mut coloured = RayHits::<Rgb>::default();
        push_sample(sample, &mut coloured, &mut report).unwrap();
        assert!(coloured.is_empty());
    }
}
