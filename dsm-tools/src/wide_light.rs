//! Lights that are too large to be taken for a point.

use deepshadow::ShadowMap;
use deepshadow::detail::Result;
use deepshadow::scene::Scene;

/// Width and height of the map that is baked for a picture, in pixels.
pub(crate) const RESOLUTION: u32 = 512;

/// That a method answers one point of a light that is large.
fn said(method: &str, [width, height]: [f64; 2]) -> String {
    format!(
        "{method} answers the light of a point, and the light is {width} × {height}: --method \
         trace of a map of kind fragments, layers or mtsm answers that"
    )
}

/// The warning that filters of a map take its light for a point, if it is wider than
/// a pixel where the map's matter begins: then shadows have edges that pixels could tell.
pub(crate) fn of_map(map: &ShadowMap) -> Result<Option<String>> {
    let (Some(extent), Some(view)) = (map.info().light, map.view()?) else { return Ok(None) };
    let tiles = map.container().directory(0)?.iter().map(|(_, tile)| tile);
    let nearest = tiles.filter(|tile| !tile.is_empty()).map(|tile| tile.z_min).reduce(f32::min);
    let [width, height] = extent.size();
    let is_wide =
        nearest.is_some_and(|depth| width.max(height) > view.pixel_size(f64::from(depth)));
    // The header keeps a light's size in `f32`.
    let shown = [width, height].map(|side| f64::from(side as f32));
    Ok(is_wide.then(|| said("filter", shown)))
}

/// The warning that `method` takes a scene's light for a point, if it is wider than a pixel
/// of the map that would be baked where the scene begins.
pub(crate) fn of_scene(scene: &Scene, method: &str) -> Option<String> {
    let [width, height] = scene.light.extent.size();
    let pixel = scene.pixel_size([RESOLUTION; 2])?;
    (width.max(height) > pixel).then(|| said(method, [width, height]))
}
