//! What is there of a plan, and whether it is what the plan says.

use std::path::Path;

use anyhow::{Context, Result};
use deepshadow::ShadowMap;
use deepshadow::files::Attribute;
use deepshadow::files::detail::Crop;

use super::job::{Plan, PlannedMap};

/// A file that may be a part of a plan.
#[derive(Clone, Debug)]
pub(crate) struct FoundPart {
    kind: &'static str,
    whole: [u32; 2],
    crop: Option<Crop>,
    tile: u32,
    scene: Option<String>,
    frame: Option<String>,
}

impl FoundPart {
    /// Reads the header of a file.
    pub(crate) fn open(path: &Path) -> Result<(Self, ShadowMap)> {
        let map = ShadowMap::open(path)?;
        let text = |name: &str| {
            let attribute = map.metadata().attributes.get(name);
            attribute.and_then(Attribute::as_text).map(str::to_owned)
        };
        let crop = map.crop();
        let whole = match crop {
            None => map.size(),
            Some(_) => map.whole_size(),
        };
        let tile = map.levels().first().map_or(0, |level| level.tile_width);
        let (scene, frame) = (text("bakeScene"), text("bakeFrame"));
        Ok((Self { kind: map.kind(), whole, crop, tile, scene, frame }, map))
    }

    /// Why it is no part of a map of the plan; None if it is one.
    pub(crate) fn foreign(&self, plan: &Plan, map: &PlannedMap) -> Option<String> {
        let [width, height] = plan.resolution;
        let (name, frame) = (map.scene_name(), map.frame.map(|frame| frame.to_string()));
        if self.kind != plan.kind {
            return Some(format!(
                "is of kind {}, and the plan's maps are of kind {}",
                self.kind, plan.kind
            ));
        }
        if self.whole != plan.resolution {
            let [own_width, own_height] = self.whole;
            return Some(format!(
                "is of a map of {own_width} × {own_height} pixels, and the plan's have {width} × {height}"
            ));
        }
        if self.scene.as_ref() != Some(&name) {
            let scene = self.scene.as_deref().unwrap_or("no scene that it names");
            return Some(format!("is of {scene}, not of {name}"));
        }
        if self.frame != frame {
            let told = |frame: &Option<String>| match frame {
                Some(frame) => format!("frame {frame}"),
                None => "no frame".to_owned(),
            };
            return Some(format!("is of {}, not of {}", told(&self.frame), told(&frame)));
        }
        if plan.parts.len() > 1 && self.tile != plan.tile {
            return Some(format!("has tiles of {} pixels, not of {}", self.tile, plan.tile));
        }
        self.part(plan).is_none().then(|| "is no part of the plan".to_owned())
    }

    /// Which part it is.
    pub(crate) fn part(&self, plan: &Plan) -> Option<usize> {
        let whole = Crop { x: 0, y: 0, width: self.whole[0], height: self.whole[1] };
        let own = self.crop.unwrap_or(whole);
        plan.parts.iter().position(|&part| Crop::of_edges(part) == own)
    }
}

/// Whether a part is there, whole and sound.
pub(crate) fn is_sound(plan: &Plan, map: &PlannedMap, part: usize, path: &Path) -> bool {
    let Ok((found, file)) = FoundPart::open(path) else { return false };
    found.foreign(plan, map).is_none() && found.part(plan) == Some(part) && file.verify().is_empty()
}

/// Refuses a map that is not sound.
pub(crate) fn verify(path: &Path) -> Result<()> {
    let map = ShadowMap::open(path)?;
    match map.verify().into_iter().next() {
        Some(error) => Err(error).with_context(|| format!("{}", path.display())),
        None => Ok(()),
    }
}
