//! Strips of pictures after the paper's figures.

use anyhow::{Context, Result, bail};
use dsm_core::detail::ShadowLookup;
use dsm_core::{BakeSettings, Filter, FilterShape, Footprint, MapInfo, Tolerance};
use dsm_scene::detail::{Camera, Image, RenderSettings};
use dsm_scene::{Motion, Object, Scene, SceneRasterizer, builtin_scene};
use glam::DVec3;
use shadow_maps::detail::PercentageCloserShadow;
use shadow_maps::plain::{DepthMap, DepthMapSettings, PercentageCloserFilter};

use super::stage::{Stage, map_settings};

/// The strips that can be drawn: figures of the paper.
pub const STRIPS: [u32; 4] = [6, 10, 11, 12];

/// Draws the strip after figure `number`, its parts `scale` times as high as
/// the smallest.
///
/// # Errors
///
/// If there is no such strip, or a map cannot be made.
pub fn strip(number: u32, scale: u32) -> Result<Image> {
    let size = |width: u32, height: u32| [width * scale, height * scale];
    let images = match number {
        6 => hair(size(24, 24))?,
        10 => cloud(size(40, 27))?,
        11 => pipes(size(40, 27))?,
        12 => sphere(size(40, 20))?,
        _ => bail!("there is no strip after figure {number}"),
    };
    Image::beside(&images).context("all are as high")
}

fn tent(width: f32) -> Result<Footprint> {
    Ok(Footprint::Isotropic(Filter::new(FilterShape::Tent, width)?))
}

/// A map of media, whose samples have no noise that would hide more.
fn close_map(side: u32) -> Result<BakeSettings> {
    Ok(map_settings(side, 16)?.with_tolerance(Tolerance::new(0.005)?))
}

/// Figure 6: the ball, and a part of its shadow under a normal map of as many
/// depths as it has pixels, one of 64 times as many, and a deep map of those.
fn hair(resolution: [u32; 2]) -> Result<Vec<Image>> {
    let scene = builtin_scene("hairball")?;
    let view = dsm_core::View { target: DVec3::new(0.0, 0.9, 0.0), ..scene.camera.view };
    let camera = Camera { view, fov: 31.0, resolution };
    let whole = Stage::new(scene, resolution)?.through(camera);
    let [mut pictures] = [whole.draw_filtered(
        &map_settings(512, 64)?,
        &[tent(2.0)?],
        &RenderSettings::new(16, 0)?,
    )?];

    // A hand's width of the floor, where the shadows of single hairs end.
    let view = dsm_core::View { target: DVec3::new(-0.2, 0.0, 0.9), ..view };
    let near = whole.through(Camera { view, fov: 4.5, resolution });
    // One lookup a pixel, as the paper's noise is that of one.
    let settings = RenderSettings::new(1, 0)?;
    for (samples, taps) in [(1, 16), (64, 400)] {
        let map = depth_map(near.scene(), samples)?;
        pictures.push(near.draw(&closer(map, taps, 3.0)?, &settings)?);
    }
    let wide = Footprint::Isotropic(Filter::new(FilterShape::Box, 3.0)?);
    pictures.extend(near.draw_filtered(&map_settings(512, 64)?, &[wide], &settings)?);
    Ok(pictures)
}

/// The light's plain shadow map, of `samples` depths a pixel.
fn depth_map(scene: &Scene, samples: u32) -> Result<DepthMap> {
    let raster = scene.light.raster([512; 2])?;
    let source = SceneRasterizer::<f32>::new(scene, raster)?;
    let mut settings = DepthMapSettings::new([512; 2], samples)?;
    settings.camera = Some(raster.shadow_camera());
    Ok(DepthMap::sample(&source, &settings)?)
}

/// Its filter, with the bias that deep maps have.
fn closer(map: DepthMap, taps: u32, width: f32) -> Result<PercentageCloserShadow> {
    let mut info = MapInfo::new();
    info.camera = map.camera().copied();
    let lookup = ShadowLookup::new(&info, map.size())?;
    let filter = PercentageCloserFilter::new(map, taps)?.with_width(width)?;
    Ok(PercentageCloserShadow::new(filter, lookup))
}

/// The scene with the objects that `keep` takes.
fn with_objects(scene: Scene, keep: impl Fn(usize, &Object) -> bool) -> Scene {
    let objects = scene.objects.iter().enumerate().filter(|(index, object)| keep(*index, object));
    let objects = objects.map(|(_, object)| object.clone()).collect();
    scene.with_objects(objects)
}

/// Figure 10: a cloud, without and with the shadow that it casts on itself.
fn cloud(resolution: [u32; 2]) -> Result<Vec<Image>> {
    let scene = builtin_scene("pipes")?;
    let last = scene.objects.len() - 1;
    let mut scene = with_objects(scene, |index, _| index == 0 || index == last);
    scene.objects[0].density *= 3.0;
    let stage = Stage::new(scene, resolution)?;
    let shadowed = RenderSettings::new(64, 0)?;
    let plain = shadowed.clone().with_self_shadowing(false);
    let draw =
        |settings| Ok(stage.draw_filtered(&close_map(256)?, &[tent(2.0)?], settings)?.remove(0));
    [plain, shadowed].iter().map(draw).collect()
}

/// Figure 11: pipes through a cloud, under one deep map, and traced.
fn pipes(resolution: [u32; 2]) -> Result<Vec<Image>> {
    let mut scene = builtin_scene("pipes")?;
    scene.objects[0].density *= 1.5;
    let stage = Stage::new(scene, resolution)?;
    let settings = RenderSettings::new(64, 0)?;
    let mut pictures = stage.draw_filtered(&close_map(512)?, &[tent(2.0)?], &settings)?;
    pictures.push(stage.draw_traced(1, &settings)?);
    Ok(pictures)
}

/// Figure 12: a moving sphere, with the shadow of one moment, and with that of
/// the whole time that the shutter is open.
fn sphere(resolution: [u32; 2]) -> Result<Vec<Image>> {
    let scene = builtin_scene("spinning-sphere")?;
    let settings = RenderSettings::new(64, 0)?;
    let stage = Stage::new(scene.clone(), resolution)?;
    let objects = scene.objects.iter().map(|object| at_half_time(object.clone())).collect();
    let frozen = scene.with_objects(objects);
    let map = depth_map(&frozen, 16)?;
    let mut pictures = vec![stage.draw(&closer(map, 64, 1.5)?, &settings)?];
    pictures.extend(stage.draw_filtered(&map_settings(512, 64)?, &[tent(2.0)?], &settings)?);
    Ok(pictures)
}

/// The object as it stands when half of the time is over.
fn at_half_time(mut object: Object) -> Object {
    for motion in &mut object.motion {
        *motion = Motion::still(motion.open.lerp(&motion.close, 0.5));
    }
    object
}
