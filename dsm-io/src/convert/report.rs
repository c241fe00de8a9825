//! Changes that an import made.

use std::ops::AddAssign;

use super::camera_reading::CameraReading;

/// Changes to the samples of an image that make them visibility functions. All
/// zero and false: none.
///
/// ```
/// let untouched = dsm_io::ImportReport::default();
/// assert_eq!(untouched, dsm_io::ImportReport::default());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ImportReport {
    /// Samples that were read.
    pub samples: u64,
    /// The image has no alpha channel: every sample is an opaque blocker.
    pub opaque_without_alpha: bool,
    /// Samples dropped because a depth is not finite.
    pub dropped_not_finite: u64,
    /// Samples with a back depth that is not finite, taken as points at their front.
    pub back_not_finite: u64,
    /// Samples dropped because they lie behind the camera.
    pub dropped_behind_camera: u64,
    /// Samples dropped because an opacity is NaN.
    pub dropped_opacity_nan: u64,
    /// Volumes of which the part behind the camera was cut off.
    pub cut_at_camera: u64,
    /// Samples with an opacity outside [0, 1], moved to the nearer end.
    pub clamped_opacity: u64,
    /// Camera matrices dropped because a number in them is not finite.
    pub dropped_matrices: u64,
    /// How the camera was read, of an image that has one.
    pub camera: Option<CameraReading>,
    /// What was chosen or mended in the file before its samples were read, a line
    /// each.
    pub source_notes: Vec<String>,
}

impl ImportReport {
    /// One line for each thing that was done; none if nothing was.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let counted = [
            (self.dropped_not_finite, "dropped: a depth is not finite"),
            (self.back_not_finite, "taken as points: the back depth is not finite"),
            (self.dropped_behind_camera, "dropped: behind the camera"),
            (self.dropped_opacity_nan, "dropped: an opacity is NaN"),
            (self.cut_at_camera, "cut at the camera: a volume reached behind it"),
            (self.clamped_opacity, "clamped: an opacity was outside [0, 1]"),
        ];
        let mut lines = self.source_notes.clone();
        let counted = counted.into_iter().filter(|&(count, _)| count > 0);
        lines.extend(
            counted.map(|(count, what)| format!("{count} of {} samples {what}", self.samples)),
        );
        if self.dropped_matrices > 0 {
            let count = self.dropped_matrices;
            lines.push(format!("{count} camera matrices dropped: a number in them is not finite"));
        }
        lines.extend(self.camera.map(|camera| camera.line()));
        if self.opaque_without_alpha {
            lines.push("no alpha channel: every sample is taken as opaque".to_owned());
        }
        lines
    }
}

impl AddAssign for ImportReport {
    fn add_assign(&mut self, other: Self) {
        self.samples += other.samples;
        self.opaque_without_alpha |= other.opaque_without_alpha;
        self.dropped_not_finite += other.dropped_not_finite;
        self.back_not_finite += other.back_not_finite;
        self.dropped_behind_camera += other.dropped_behind_camera;
        self.dropped_opacity_nan += other.dropped_opacity_nan;
        self.cut_at_camera += other.cut_at_camera;
        self.clamped_opacity += other.clamped_opacity;
        self.dropped_matrices += other.dropped_matrices;
        self.camera = self.camera.or(other.camera);
        self.source_notes.extend(other.source_notes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_only_what_was_done() {
        let quiet = ImportReport { samples: 9, ..Default::default() };
        assert!(quiet.lines().is_empty());
        let mut sum = quiet;
        sum += ImportReport { samples: 1, clamped_opacity: 2, ..Default::default() };
        sum += ImportReport { opaque_without_alpha: true, ..Default::default() };
        assert_eq!(
            sum.lines(),
            [
                "2 of 10 samples clamped: an opacity was outside [0, 1]",
                "no alpha channel: every sample is taken as opaque",
            ]
        );
    }
}
