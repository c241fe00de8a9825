//! The conventions that the camera matrices of an image follow, and their change
//! to those of maps.
//!
//! OpenEXR's standard attributes have a left-handed camera space with x to the
//! right, y up and +z in the viewing direction, and NDC [0, 1]² with y down. There
//! are files with a right-handed camera space that is looked at along −z, and with
//! NDC [−1, 1]² and y up. What the matrices show decides.

use dsm_core::ShadowCamera;
use glam::{DMat4, DVec2, DVec4};

/// The viewing direction in the camera space of an image.
///
/// ```
/// assert_eq!(dsm_io::detail::ViewAxis::PlusZ.name(), "+z");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewAxis {
    /// +z, as OpenEXR defines `worldToCamera`.
    PlusZ,
    /// −z, as in OpenGL.
    MinusZ,
}

impl ViewAxis {
    /// `+z` or `-z`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::PlusZ => "+z",
            Self::MinusZ => "-z",
        }
    }
}

/// The square that the display window has in the NDC of an image.
///
/// ```
/// assert_eq!(dsm_io::detail::NdcRange::Unit.name(), "[0, 1]");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NdcRange {
    /// [0, 1]², as OpenEXR defines `worldToNDC`.
    Unit,
    /// [−1, 1]², as clip space.
    Screen,
}

impl NdcRange {
    /// `[0, 1]` or `[-1, 1]`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unit => "[0, 1]",
            Self::Screen => "[-1, 1]",
        }
    }
}

/// The conventions to read an image's camera by; what is `None` is decided by its
/// matrices.
///
/// ```
/// use dsm_io::detail::{CameraConventions, ViewAxis};
///
/// let conventions = CameraConventions { view_axis: Some(ViewAxis::MinusZ), ..Default::default() };
/// assert_eq!(conventions.ndc_range, None);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CameraConventions {
    /// The viewing direction.
    pub view_axis: Option<ViewAxis>,
    /// The range of NDC.
    pub ndc_range: Option<NdcRange>,
}

/// What an image's camera was taken to be.
///
/// ```
/// // An image without a camera has none.
/// assert_eq!(dsm_io::ImportReport::default().camera, None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct CameraReading {
    /// The viewing direction.
    pub view_axis: ViewAxis,
    /// What `worldToNDC` shows the viewing direction to be, if it does.
    pub axis_in_ndc: Option<ViewAxis>,
    /// The range of NDC.
    pub ndc_range: NdcRange,
    /// True if y of NDC goes up.
    pub y_is_up: bool,
}

impl CameraReading {
    /// One line that says how the matrices were read.
    #[must_use]
    pub fn line(&self) -> String {
        let y = if self.y_is_up { "up" } else { "down" };
        let mut line = format!(
            "camera: looks along {} of worldToCamera, NDC {} with y {y}",
            self.view_axis.name(),
            self.ndc_range.name(),
        );
        match self.axis_in_ndc {
            Some(axis) if axis != self.view_axis => {
                line += &format!(", though worldToNDC looks along {}", axis.name());
            }
            Some(ViewAxis::MinusZ) => line += "; OpenEXR's own would be +z",
            _ => {}
        }
        line
    }
}

impl CameraConventions {
    /// The camera of maps that an image's matrices stand for, as column-vector
    /// matrices, and how they were read.
    pub(super) fn read(
        self,
        world_to_camera: Option<DMat4>,
        world_to_ndc: Option<DMat4>,
    ) -> (ShadowCamera, CameraReading) {
        let axis_in_ndc = world_to_camera.zip(world_to_ndc).and_then(|(c, n)| axis_shown(c, n));
        let view_axis = self.view_axis.or(axis_in_ndc).unwrap_or(ViewAxis::PlusZ);
        let world_to_camera = world_to_camera.map(|matrix| looking_down(view_axis, matrix));
        let camera = ShadowCamera { world_to_camera, world_to_ndc };
        let shown = ndc_shown(&camera);
        let (ndc_range, y_is_up) = match (self.ndc_range, shown) {
            (None, shown) => shown.unwrap_or((NdcRange::Unit, false)),
            (Some(range), None) => (range, range == NdcRange::Screen),
            (Some(range), Some((_, y_is_up))) => (range, y_is_up),
        };
        let world_to_ndc = world_to_ndc.map(|matrix| in_unit_ndc(ndc_range, y_is_up, matrix));
        let reading = CameraReading { view_axis, axis_in_ndc, ndc_range, y_is_up };
        (ShadowCamera { world_to_camera, world_to_ndc }, reading)
    }
}

/// The matrix to OpenEXR's camera space from one to the camera space of maps, and
/// back: z changes its sign, which rounds nothing.
pub(super) fn z_reversed(matrix: DMat4) -> DMat4 {
    DMat4::from_cols_array_2d(&matrix.to_cols_array_2d().map(|[x, y, z, w]| [x, y, -z, w]))
}

fn looking_down(axis: ViewAxis, matrix: DMat4) -> DMat4 {
    match axis {
        ViewAxis::PlusZ => z_reversed(matrix),
        ViewAxis::MinusZ => matrix,
    }
}

/// The viewing direction by both matrices, where they show one.
fn axis_shown(world_to_camera: DMat4, world_to_ndc: DMat4) -> Option<ViewAxis> {
    let z_row = world_to_camera.row(2).truncate();
    // The cosine of the angle between a row of NDC and the camera's z.
    let along_z = |row: DVec4| {
        let cosine = row.truncate().dot(z_row) / (row.truncate().length() * z_row.length());
        (cosine.abs() > 0.5).then_some(cosine > 0.0)
    };
    let axis = |is_plus: bool| if is_plus { ViewAxis::PlusZ } else { ViewAxis::MinusZ };
    let w_row = world_to_ndc.row(3);
    if world_to_ndc_is_perspective(world_to_ndc) {
        // What is seen has a positive w.
        along_z(w_row).map(axis)
    } else {
        // Without a perspective divide only z tells, and few agree on what NDC's z
        // is: the handedness has to say the same.
        let toward_plus = along_z(world_to_ndc.row(2) * w_row.w.signum())?;
        let is_left_handed = world_to_camera.determinant() < 0.0;
        (toward_plus == is_left_handed).then(|| axis(toward_plus))
    }
}

/// True if w changes with the place. Rotations and scales give rows whose lengths
/// are compared; what is left of a w row that should be 0 is rounding.
fn world_to_ndc_is_perspective(ndc: DMat4) -> bool {
    let [x, y, w] = [0, 1, 3].map(|row| ndc.row(row).truncate().length());
    w > x.max(y) * 1e-6
}

/// The range and the direction of y that the NDC of a camera shows, which looks down
/// −z of its camera space.
fn ndc_shown(camera: &ShadowCamera) -> Option<(NdcRange, bool)> {
    let (projection, _) = camera.projection().ok()?;
    let (camera_y, origin) = (projection.col(1), projection.col(3));
    // Where the axis lands: at infinity in perspective, anywhere else.
    let far = -projection.col(2);
    let seen = if world_to_ndc_is_perspective(projection) { far } else { origin };
    let ndc = DVec2::new(seen.x, seen.y) / seen.w;
    let y_rate = camera_y.y * seen.w;
    if !ndc.is_finite() || !y_rate.is_finite() || y_rate == 0.0 {
        return None;
    }
    let y_is_up = y_rate > 0.0;
    let [to_unit, to_screen] = [0.5, 0.0].map(|middle| (ndc - middle).length());
    // An axis that lands between the two middles belongs to a window off the axis.
    let range = if (to_unit - to_screen).abs() > 0.25 {
        if to_unit < to_screen { NdcRange::Unit } else { NdcRange::Screen }
    } else if y_is_up {
        NdcRange::Screen
    } else {
        NdcRange::Unit
    };
    Some((range, y_is_up))
}

/// The matrix to NDC [0, 1]², y down.
fn in_unit_ndc(range: NdcRange, y_is_up: bool, matrix: DMat4) -> DMat4 {
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| matrix.row(row));
    let y = if y_is_up { -y } else { y };
    let (x, y) = match range {
        NdcRange::Unit if y_is_up => (x, y + w),
        NdcRange::Unit => return matrix,
        NdcRange::Screen => ((x + w) / 2.0, (y + w) / 2.0),
    };
    DMat4::from_cols(x, y, z, w).transpose()
}

#[cfg(test)]
mod tests {
    use dsm_core::{Projection, View};
    use glam::DVec3;

    use super::*;

    fn cameras() -> impl Iterator<Item = ShadowCamera> {
        let views = [
            View { eye: DVec3::new(3.0, -4.0, 5.0), target: DVec3::ZERO, up: DVec3::Y },
            View { eye: DVec3::new(-300.0, 1e4, 7.0), target: DVec3::X, up: DVec3::Z },
        ];
        let projections =
            [Projection::Perspective { fov: 40.0 }, Projection::Orthographic { extent: 7.0 }];
        views.into_iter().flat_map(move |view| {
            projections.map(|projection| view.raster(projection, [64, 48]).unwrap().shadow_camera())
        })
    }

    /// The same matrices in `f32`, as files hold them, by these conventions.
    fn in_file(
        camera: &ShadowCamera,
        axis: ViewAxis,
        range: NdcRange,
        y_is_up: bool,
    ) -> [Option<DMat4>; 2] {
        let matrix = looking_down(axis, camera.world_to_camera.unwrap());
        let ndc = camera.world_to_ndc.unwrap();
        let [x, mut y, z, w] = [0, 1, 2, 3].map(|row| ndc.row(row));
        if y_is_up {
            y = w - y;
        }
        let rows = match range {
            NdcRange::Unit => [x, y, z, w],
            NdcRange::Screen => [x * 2.0 - w, y * 2.0 - w, z, w],
        };
        let ndc = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
        [matrix, ndc].map(|matrix| Some(matrix.as_mat4().as_dmat4()))
    }

    #[test]
    fn all_conventions_give_the_same_camera() {
        for camera in cameras() {
            for axis in [ViewAxis::PlusZ, ViewAxis::MinusZ] {
                for range in [NdcRange::Unit, NdcRange::Screen] {
                    for y_is_up in [false, true] {
                        let [matrix, ndc] = in_file(&camera, axis, range, y_is_up);
                        let (read, reading) = CameraConventions::default().read(matrix, ndc);
                        assert_eq!(
                            (reading.view_axis, reading.ndc_range, reading.y_is_up),
                            (axis, range, y_is_up),
                            "{reading:?} {camera:?}"
                        );
                        let point = DVec3::new(0.3, 0.2, -0.1);
                        let [want, got] = [&camera, &read].map(|c| c.project(point).unwrap());
                        let off = (want.unwrap() - got.unwrap()).abs();
                        assert!(off.max_element() < 2e-3, "{off}");
                        assert!(off.truncate().max_element() < 2e-4, "{off}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_window_off_the_axis_is_told_by_the_direction_of_y() {
        let [camera, ..] = cameras().collect::<Vec<_>>()[..] else { panic!("no cameras") };
        let ndc = camera.world_to_ndc.unwrap();
        // The axis lands on (0.2, 0.3) of a window beside it.
        let shift =
            DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::Z, DVec4::new(-0.3, -0.2, 0.0, 1.0));
        let beside = ShadowCamera { world_to_ndc: Some(shift * ndc), ..camera };
        for (range, y_is_up) in [(NdcRange::Unit, false), (NdcRange::Screen, true)] {
            let [matrix, ndc] = in_file(&beside, ViewAxis::PlusZ, range, y_is_up);
            let (_, reading) = CameraConventions::default().read(matrix, ndc);
            assert_eq!((reading.ndc_range, reading.y_is_up), (range, y_is_up));
        }
    }

    #[test]
    fn one_matrix_is_read_as_the_standard_has_it() {
        let camera = cameras().next().unwrap();
        let [matrix, _] = in_file(&camera, ViewAxis::PlusZ, NdcRange::Unit, false);
        let (read, reading) = CameraConventions::default().read(matrix, None);
        assert_eq!((reading.view_axis, reading.axis_in_ndc), (ViewAxis::PlusZ, None));
        let z = |matrix: Option<DMat4>| matrix.unwrap().transform_point3(DVec3::ZERO).z;
        assert!((z(read.world_to_camera) - z(camera.world_to_camera)).abs() < 1e-5);
    }

    #[test]
    fn a_switch_is_obeyed_and_the_contradiction_said() {
        let camera = cameras().next().unwrap();
        let [matrix, ndc] = in_file(&camera, ViewAxis::PlusZ, NdcRange::Unit, false);
        let asked = CameraConventions { view_axis: Some(ViewAxis::MinusZ), ndc_range: None };
        let (_, reading) = asked.read(matrix, ndc);
        assert!(reading.line().contains("though worldToNDC looks along +z"), "{}", reading.line());
    }
}
