//! Built-in scenes, reproducible on every platform.
//!
//! Numbers come from a seeded generator, angles from `libm`, and everything
//! else from operations that IEEE 754 rounds in one way only.

mod cloud;
mod foliage;
mod glass;
mod motion;
mod random;
mod solid;
mod strands;

use crate::error::{Error, Result};
use crate::scene::Scene;

/// The names of the built-in scenes.
///
/// ```
/// assert!(dsm_scene::detail::BUILTIN_SCENES.contains(&"hairball"));
/// ```
pub const BUILTIN_SCENES: &[&str] =
    &["hairball", "fur-plane", "foliage", "smoke", "pipes", "spinning-sphere", "stained-glass"];

/// Makes a built-in scene, with its light and its camera.
///
/// | name | what | after |
/// |---|---|---|
/// | `hairball` | 50,000 curly hairs of 16 segments on a ball over a floor | Lokovic & Veach 2000, §6 |
/// | `fur-plane` | 40,000 tapered hairs on a square | |
/// | `foliage` | 300,000 leaf triangles in 600 clusters over a floor | |
/// | `smoke` | a plume of 64 × 128 × 64 voxels over a floor | |
/// | `pipes` | a cloud with pipes through it | Lokovic & Veach 2000, figure 11 |
/// | `spinning-sphere` | a sphere of slices that flies and turns | Lokovic & Veach 2000, figure 12 |
/// | `stained-glass` | panes of six colours in lead | Lokovic & Veach 2000, §5.2 |
///
/// # Errors
///
/// [`Error::UnknownBuiltin`] for another name.
///
/// ```
/// let scene = dsm_scene::builtin_scene("stained-glass")?;
/// assert!(scene.is_coloured());
/// # Ok::<(), dsm_scene::Error>(())
/// ```
pub fn builtin_scene(name: &str) -> Result<Scene> {
    match name {
        "hairball" => strands::hairball(),
        "fur-plane" => strands::fur_plane(),
        "foliage" => foliage::foliage(),
        "smoke" => cloud::smoke(),
        "pipes" => cloud::pipes(),
        "spinning-sphere" => motion::spinning_sphere(),
        "stained-glass" => glass::stained_glass(),
        _ => Err(Error::UnknownBuiltin { name: name.to_owned(), known: BUILTIN_SCENES }),
    }
}
