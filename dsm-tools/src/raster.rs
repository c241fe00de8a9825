//! Where the points of a scene lie in a map.

use anyhow::{Context, Result};
use dsm_core::{MapInfo, PixelWindow, ShadowCamera};
use glam::{DVec2, DVec3};

/// Takes points of the world to a map's raster: pixel (i, j) covers
/// [i, i+1) × [j, j+1), and z is the depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorldToRaster {
    camera: ShadowCamera,
    /// Pixels that NDC [0, 1]² covers: the display window's size.
    scale: DVec2,
    /// The display window's corner, seen from the map's.
    corner: DVec2,
}

impl WorldToRaster {
    /// The way into a map of `size` pixels. A window that the map doesn't
    /// know is the map itself.
    pub(crate) fn new(info: &MapInfo, size: [u32; 2]) -> Result<Self> {
        let camera =
            info.camera.context("the map has no camera to project points of the world with")?;
        // Only a matrix that is missing is an error.
        camera.project(DVec3::ZERO)?;
        let known = |window: Option<PixelWindow>| window.filter(|w| !w.size().contains(&0));
        let display = known(info.display_window).or(known(info.data_window));
        let scale = display.map_or(size.map(f64::from), |window| window.size().map(|n| n as f64));
        let corner = match (known(info.display_window), info.data_window) {
            (Some(display), Some(data)) => {
                [0, 1].map(|axis| f64::from(display.min[axis]) - f64::from(data.min[axis]))
            }
            _ => [0.0; 2],
        };
        Ok(Self { camera, scale: scale.into(), corner: corner.into() })
    }

    /// The raster position and depth of a point of the world; `None` behind
    /// the camera and where the projection is not finite.
    pub(crate) fn project(&self, world: DVec3) -> Result<Option<DVec3>> {
        let projected = self.camera.project(world)?;
        Ok(projected.map(|ndc| (self.corner + ndc.truncate() * self.scale).extend(ndc.z)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat4, Vec4};

    /// Looks down −z from the origin; NDC covers [−1, 1]², y up.
    fn info() -> MapInfo {
        let ndc = Mat4::from_rows(
            Vec4::new(0.5, 0.0, 0.0, 0.5),
            Vec4::new(0.0, -0.5, 0.0, 0.5),
            Vec4::Z,
            Vec4::W,
        );
        let camera =
            ShadowCamera { world_to_camera: Some(Mat4::IDENTITY), world_to_ndc: Some(ndc) };
        MapInfo { camera: Some(camera), ..MapInfo::default() }
    }

    fn project(info: &MapInfo, world: [f64; 3]) -> Option<[f64; 3]> {
        let raster = WorldToRaster::new(info, [10, 20]).unwrap();
        raster.project(world.into()).unwrap().map(Into::into)
    }

    #[test]
    fn ndc_covers_the_display_window() {
        let upper_left = [-1.0, 1.0, -3.0];
        assert_eq!(project(&info(), upper_left), Some([0.0, 0.0, 3.0]));
        assert_eq!(project(&info(), [0.5, -1.0, -3.0]), Some([7.5, 20.0, 3.0]));
        let data = Some(PixelWindow { min: [5, 6], max: [14, 25] });
        let display = Some(PixelWindow { min: [1, -2], max: [100, 97] });
        let info = MapInfo { data_window: data, display_window: display, ..info() };
        assert_eq!(project(&info, upper_left), Some([-4.0, -8.0, 3.0]));
        assert_eq!(project(&info, [1.0, -1.0, -3.0]), Some([96.0, 92.0, 3.0]));
        let info = MapInfo { display_window: None, ..info };
        assert_eq!(project(&info, upper_left), Some([0.0, 0.0, 3.0]));
    }

    #[test]
    fn behind_the_camera_is_nowhere() {
        assert_eq!(project(&info(), [0.0, 0.0, 1.0]), None);
        assert_eq!(project(&info(), [f64::NAN, 0.0, -1.0]), None);
    }

    #[test]
    fn a_map_needs_a_whole_camera() {
        let refused = |info: &MapInfo| WorldToRaster::new(info, [10, 20]).unwrap_err().to_string();
        assert!(refused(&MapInfo::default()).contains("no camera"));
        let half = ShadowCamera { world_to_ndc: None, ..info().camera.unwrap() };
        assert!(refused(&MapInfo { camera: Some(half), ..info() }).contains("NDC"));
    }
}
