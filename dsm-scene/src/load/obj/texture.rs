//! The opacity map of a material, `map_d`.

use std::path::{Path, PathBuf};

use glam::{Affine2, Mat2, Vec2};

use super::text::{name, number, split_word};
use crate::alpha::{AlphaTexture, Wrap};
use crate::error::Result;
use crate::load::image::Channel;
use crate::load::library::Library;
use crate::load::read_file;
use crate::load::warnings::Warnings;

/// A file's name and the options before it.
#[derive(Clone, Debug)]
pub(super) struct TextureMap {
    file: String,
    clamp: bool,
    channel: Channel,
    /// Offset and gain of values.
    base_gain: [f32; 2],
    offset: Vec2,
    scale: Vec2,
    /// An option that is not followed.
    unknown: Option<String>,
}

impl TextureMap {
    /// Reads what follows `map_d`.
    pub(super) fn parse(text: &[u8]) -> std::result::Result<Self, &'static str> {
        let mut map = Self {
            file: String::new(),
            clamp: false,
            channel: Channel::AlphaOrBrightness,
            base_gain: [0.0, 1.0],
            offset: Vec2::ZERO,
            scale: Vec2::ONE,
            unknown: None,
        };
        let mut rest = text.trim_ascii();
        loop {
            let (word, after) = split_word(rest);
            let option = match word.strip_prefix(b"-") {
                // A name may begin so, too.
                Some(option) if !after.is_empty() => option.to_ascii_lowercase(),
                _ => break,
            };
            rest = match option.as_slice() {
                b"blendu" | b"blendv" | b"cc" | b"texres" => split_word(after).1,
                b"clamp" => {
                    let (value, after) = split_word(after);
                    map.clamp = value.eq_ignore_ascii_case(b"on");
                    after
                }
                b"imfchan" => {
                    let (value, after) = split_word(after);
                    map.channel = match value {
                        b"r" => Channel::Red,
                        b"g" => Channel::Green,
                        b"b" => Channel::Blue,
                        b"m" => Channel::Alpha,
                        b"l" => Channel::Brightness,
                        _ => return Err("-imfchan is followed by one of r, g, b, m, l"),
                    };
                    after
                }
                b"mm" => {
                    let (values, after) = numbers(after, 2);
                    let [base, gain] = values[..] else {
                        return Err("-mm is followed by two numbers");
                    };
                    map.base_gain = [base, gain];
                    after
                }
                b"o" => {
                    let (values, after) = numbers(after, 3);
                    map.offset = two(&values, 0.0).ok_or("-o is followed by numbers")?;
                    after
                }
                b"s" => {
                    let (values, after) = numbers(after, 3);
                    map.scale = two(&values, 1.0).ok_or("-s is followed by numbers")?;
                    after
                }
                b"t" => {
                    map.unknown = Some("-t".to_owned());
                    numbers(after, 3).1
                }
                b"bm" | b"boost" => split_word(after).1,
                // Perhaps a part of the name; else the file will not be there.
                _ => break,
            };
        }
        map.file = name(rest);
        if map.file.is_empty() { Err("map_d names no file") } else { Ok(map) }
    }

    /// The texture: `None` if it is opaque everywhere.
    pub(super) fn load(
        &self,
        folder: &Path,
        material: &str,
        library: &Library,
        warnings: &mut Warnings,
    ) -> Result<Option<AlphaTexture>> {
        if let Some(option) = &self.unknown {
            warnings.add(format!("material {material}: {option} of its map_d is left out"));
        }
        let path = find(folder, &self.file);
        let texture = library
            .image((path.clone(), None), self.channel, || read_file(&path))
            .map_err(|error| error.in_file(&path))?;
        let Some(mut texture) = texture else { return self.evenly(1.0) };
        if self.base_gain != [0.0, 1.0] {
            texture = texture.mapped(|value| self.value(value));
        }
        if self.clamp {
            texture.wrap = [Wrap::Clamp; 2];
        }
        if (self.scale, self.offset) != (Vec2::ONE, Vec2::ZERO) {
            // Of coordinates whose v goes up: the mesh's and the texture's go down.
            let down = Mat2::from_diagonal(Vec2::new(1.0, -1.0));
            let flip = Affine2::from_mat2_translation(down, Vec2::Y);
            let scale = Mat2::from_diagonal(self.scale);
            texture.uv_transform = flip * Affine2::from_mat2_translation(scale, self.offset) * flip;
        }
        Ok(Some(texture))
    }

    fn value(&self, value: f32) -> f32 {
        let [base, gain] = self.base_gain;
        (base + gain * value).clamp(0.0, 1.0)
    }

    /// A texture that has one value all over, unless that is opaque.
    fn evenly(&self, value: f32) -> Result<Option<AlphaTexture>> {
        let value = self.value(value);
        if value >= 1.0 {
            return Ok(None);
        }
        AlphaTexture::new(1, 1, vec![(value * 255.0).round() as u8]).map(Some)
    }
}

/// Up to `most` numbers, and what follows them.
fn numbers(mut text: &[u8], most: usize) -> (Vec<f32>, &[u8]) {
    let mut found = Vec::new();
    while found.len() < most {
        let (word, after) = split_word(text);
        // A file may be called 1: the last word is the name.
        let Some(value) = number(word).filter(|value| value.is_finite() && !after.is_empty())
        else {
            break;
        };
        found.push(value);
        text = after;
    }
    (found, text)
}

fn two(values: &[f32], missing: f32) -> Option<Vec2> {
    let first = values.first()?;
    Some(Vec2::new(*first, values.get(1).copied().unwrap_or(missing)))
}

/// The file of this name: as written, or beside the library if it was written for
/// another machine's folders.
pub(super) fn find(folder: &Path, file: &str) -> PathBuf {
    let file = file.replace('\\', "/");
    let path = folder.join(&file);
    if path.exists() {
        return path;
    }
    let last = file.rsplit('/').next().unwrap_or(&file);
    let beside = folder.join(last);
    if beside.is_file() { beside } else { path }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_come_before_a_name_with_spaces() {
        let map = TextureMap::parse(b"-clamp on -mm 0.5 2 -o .1 -s 2 3 4 -imfchan r leaf 1.png");
        let map = map.unwrap();
        assert_eq!((map.file.as_str(), map.clamp, map.channel), ("leaf 1.png", true, Channel::Red));
        assert_eq!(
            (map.base_gain, map.offset, map.scale),
            ([0.5, 2.0], Vec2::new(0.1, 0.0), Vec2::new(2.0, 3.0))
        );
        for (text, file) in [
            ("-o 1 2 3 4 leaf.png", "4 leaf.png"),
            ("-s 1 2.png", "2.png"),
            ("-leaf.png", "-leaf.png"),
            ("-leaf 2.png", "-leaf 2.png"),
            ("\"a b.png\"", "a b.png"),
            ("-blendu off -blendv on -cc off -texres 512 -t 1 1 1 -bm 1 a.png", "a.png"),
        ] {
            assert_eq!(TextureMap::parse(text.as_bytes()).unwrap().file, file, "{text}");
        }
        for text in ["", "-mm 1 a.png", "-imfchan x a.png", "-o a.png"] {
            assert!(TextureMap::parse(text.as_bytes()).is_err(), "{text}");
        }
    }

    #[test]
    fn files_of_other_folders_are_found_beside() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("leaf.png");
        std::fs::write(&path, b"").unwrap();
        assert_eq!(find(folder.path(), "C:\\Users\\a\\leaf.png"), path);
        assert_eq!(find(folder.path(), "no/other.png"), folder.path().join("no/other.png"));
    }
}
