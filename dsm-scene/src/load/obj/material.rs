//! Materials of MTL files.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::text::{Lines, name, number, split_word, words};
use super::texture::TextureMap;
use crate::alpha::{Alpha, AlphaMode};
use crate::error::{Error, Place, Result};
use crate::load::library::Library;
use crate::load::read_file;
use crate::load::warnings::Warnings;

/// What a material says of opacity.
#[derive(Clone, Debug, Default)]
struct Material {
    dissolve: Option<f32>,
    transparency: Option<f32>,
    map: Option<TextureMap>,
}

/// The materials of the libraries so far, by name.
#[derive(Debug, Default)]
pub(super) struct Materials {
    by_name: HashMap<String, (Material, PathBuf)>,
    /// Files that were read: a second time they would add nothing.
    libraries: HashSet<PathBuf>,
}

impl Materials {
    /// Adds a library, if there is such a file: the first material of a name counts.
    pub(super) fn add_library(&mut self, path: &Path, warnings: &mut Warnings) -> Result<()> {
        if !self.libraries.insert(path.to_owned()) {
            return Ok(());
        }
        let bytes = read_file(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut open: Option<(String, Material)> = None;
        for (line, text) in Lines::new(&bytes) {
            let (word, rest) = split_word(&text);
            if word.eq_ignore_ascii_case(b"newmtl") {
                self.keep(open.replace((name(rest), Material::default())), folder);
                continue;
            }
            let Some((of, material)) = &mut open else { continue };
            let malformed = |reason: String| Error::malformed(Place::Line(line), reason);
            let value = |rest: &[u8], key: &str| {
                let value = words(rest).next().and_then(number).filter(|value| !value.is_nan());
                value.ok_or_else(|| malformed(format!("{key} is not a number")))
            };
            if word.eq_ignore_ascii_case(b"d") {
                let (first, after) = split_word(rest);
                if first == b"-halo" {
                    warnings.add(format!(
                        "material {of}: its d -halo is taken as seen face on, from every side"
                    ));
                    material.dissolve = Some(value(after, "d")?);
                } else {
                    material.dissolve = Some(value(rest, "d")?);
                }
            } else if word.eq_ignore_ascii_case(b"Tr") {
                material.transparency = Some(value(rest, "Tr")?);
            } else if word.eq_ignore_ascii_case(b"map_d") {
                let map = TextureMap::parse(rest);
                material.map = Some(map.map_err(|reason| malformed(reason.to_owned()))?);
            }
        }
        self.keep(open, folder);
        Ok(())
    }

    fn keep(&mut self, material: Option<(String, Material)>, folder: &Path) {
        if let Some((name, material)) = material {
            self.by_name.entry(name).or_insert((material, folder.to_owned()));
        }
    }

    /// The opacity of the material of this name, if there is one. Its image is read.
    pub(super) fn alpha(
        &self,
        name: &str,
        library: &Library,
        warnings: &mut Warnings,
    ) -> Result<Option<Alpha>> {
        let Some((material, folder)) = self.by_name.get(name) else { return Ok(None) };
        let factor = factor(material, name, warnings);
        let texture = match &material.map {
            None => None,
            Some(map) => map.load(folder, name, library, warnings)?,
        };
        Ok(Some(Alpha { mode: AlphaMode::Blend, factor, texture }))
    }
}

/// The opacity that a material's numbers stand for, in [0, 1].
fn factor(material: &Material, name: &str, warnings: &mut Warnings) -> f32 {
    let factor = match (material.dissolve, material.transparency) {
        (None, None) => 1.0,
        (Some(dissolve), None) => dissolve,
        (Some(dissolve), Some(transparency)) => {
            // Both with a few decimals.
            if (dissolve + transparency - 1.0).abs() > 0.01 {
                warnings.add(format!(
                    "material {name}: its d {dissolve} and Tr {transparency} do not add up to 1; \
                     d counts"
                ));
            }
            dissolve
        }
        (None, Some(transparency)) => {
            if transparency >= 1.0 {
                warnings.add(format!(
                    "material {name}: Tr {transparency} without d makes it invisible; some \
                     programs write that for opaque, which is d 1"
                ));
            }
            1.0 - transparency
        }
    };
    if !(0.0..=1.0).contains(&factor) {
        warnings.add(format!("material {name}: opacity {factor} is taken into [0, 1]"));
    }
    factor.clamp(0.0, 1.0)
}
