//! The binary encoding of USD layers, "crate" files, since version 0.4.

mod arrays;
mod compressed;
mod cursor;
mod items;
mod sections;

use std::collections::HashMap;

use self::cursor::Cursor;
use self::sections::Sections;
use super::layer::{Layer, PrimSpec, Property, Specifier};
use super::value::{ListOp, Stored, Value};
use crate::error::{Error, Place, Result};

/// What a binary file begins with.
pub(super) const MAGIC: &[u8] = b"PXR-USDC";

/// Kinds of specs.
mod kind {
    pub(super) const ATTRIBUTE: i64 = 1;
    pub(super) const PRIM: i64 = 6;
    pub(super) const ROOT: i64 = 7;
    pub(super) const RELATIONSHIP: i64 = 8;
    pub(super) const VARIANT: i64 = 10;
}

/// An element of a path, below its parent's.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathNode {
    pub(super) parent: u32,
    pub(super) token: u32,
    pub(super) is_property: bool,
    pub(super) depth: u16,
}

/// A binary file's bytes with the tables that its values need.
#[derive(Debug)]
pub(super) struct CrateFile {
    bytes: Vec<u8>,
    version: [u8; 3],
    text: Vec<u8>,
    /// Where each token lies in `text`.
    tokens: Vec<(u32, u32)>,
    /// The token of each string.
    strings: Vec<u32>,
    paths: Vec<PathNode>,
}

/// Reads a layer.
pub(super) fn read(bytes: Vec<u8>) -> Result<Layer> {
    let (file, sections) = Sections::read(bytes)?;
    let mut prims = vec![PrimSpec::default()];
    // The prim of each path.
    let mut places: HashMap<u32, u32> = HashMap::new();
    let is_prim = |kind| matches!(kind, kind::PRIM | kind::ROOT | kind::VARIANT);
    for &(path, fields, _) in sections.specs.iter().filter(|spec| is_prim(spec.2)) {
        let node = file.path_node(path)?;
        let place = if node.depth == 0 {
            0
        } else {
            prims.push(PrimSpec::default());
            prims.len() as u32 - 1
        };
        if places.insert(path, place).is_some() {
            return Err(Error::malformed(Place::Whole, "two prims of the same path"));
        }
        let prim = &mut prims[place as usize];
        for (name, packed) in sections.fields(&file, fields)? {
            match name {
                "specifier" => {
                    prim.specifier = match packed & 0xffff_ffff {
                        0 => Specifier::Def,
                        2 => Specifier::Class,
                        _ => Specifier::Over,
                    }
                }
                "typeName" => prim.type_name = file.inlined_token(packed)?.to_owned(),
                _ => {
                    prim.fields.insert(name.to_owned(), Stored::Packed(packed));
                }
            }
        }
    }
    for (&path, &place) in &places {
        let node = file.path_node(path)?;
        let Some(&parent) = places.get(&node.parent).filter(|_| place != 0) else { continue };
        let name = file.token(node.token)?;
        let parent = &mut prims[parent as usize];
        match name.strip_prefix('{').and_then(|name| name.strip_suffix('}')) {
            Some(variant) => {
                let (set, variant) = variant.split_once('=').unwrap_or((variant, ""));
                parent.variants.push((set.to_owned(), variant.to_owned(), place));
            }
            None => parent.add_child(name, place),
        }
    }
    let is_property = |kind| matches!(kind, kind::ATTRIBUTE | kind::RELATIONSHIP);
    for &(path, fields, _) in sections.specs.iter().filter(|spec| is_property(spec.2)) {
        let node = file.path_node(path)?;
        let Some(&place) = places.get(&node.parent).filter(|_| node.is_property) else { continue };
        let mut property = Property::default();
        for (name, packed) in sections.fields(&file, fields)? {
            match name {
                "default" => property.default = Some(Stored::Packed(packed)),
                "timeSamples" => property.samples = Some(Stored::Packed(packed)),
                "targetPaths" | "connectionPaths" => {
                    property.targets = Some(Stored::Packed(packed));
                }
                "interpolation" => {
                    property.interpolation = Some(file.inlined_token(packed)?.to_owned());
                }
                _ => {}
            }
        }
        let name = file.token(node.token)?.to_owned();
        prims[place as usize].properties.insert(name, property);
    }
    // Siblings in the order of their names, whatever the tables say.
    for prim in &mut prims {
        prim.children.sort_unstable();
    }
    Ok(Layer { prims, packed: Some(file) })
}

impl CrateFile {
    pub(super) fn token(&self, index: u32) -> Result<&str> {
        let unknown = || Error::malformed(Place::Whole, "a token is out of range");
        let &(start, end) = self.tokens.get(index as usize).ok_or_else(unknown)?;
        let text = &self.text[start as usize..end as usize];
        std::str::from_utf8(text)
            .map_err(|_| Error::malformed(Place::Whole, "a token is not in UTF-8"))
    }

    fn string(&self, index: u32) -> Result<&str> {
        let unknown = || Error::malformed(Place::Whole, "a string is out of range");
        self.token(*self.strings.get(index as usize).ok_or_else(unknown)?)
    }

    fn inlined_token(&self, packed: u64) -> Result<&str> {
        self.token(packed as u32)
    }

    fn path_node(&self, index: u32) -> Result<PathNode> {
        let unknown = || Error::malformed(Place::Whole, "a path is out of range");
        self.paths.get(index as usize).copied().ok_or_else(unknown)
    }

    /// A path as text.
    fn path(&self, index: u32) -> Result<String> {
        let mut node = self.path_node(index)?;
        let mut parts = Vec::new();
        while node.depth > 0 {
            let name = self.token(node.token)?;
            // Variants and targets of targets bring their own marks.
            let mark = if node.is_property {
                "."
            } else if name.starts_with(['{', '[']) {
                ""
            } else {
                "/"
            };
            parts.push((mark, name));
            node = self.path_node(node.parent)?;
        }
        if parts.is_empty() {
            return Ok("/".to_owned());
        }
        let path: String = parts.into_iter().rev().flat_map(|(mark, name)| [mark, name]).collect();
        Ok(path.replace("}/", "}"))
    }

    fn cursor(&self, at: u64) -> Result<Cursor<'_>> {
        Cursor::new(&self.bytes, at)
    }

    /// The value behind these bits.
    pub(super) fn value(&self, packed: u64) -> Result<Value> {
        let kind = (packed >> 48) as u8;
        let (is_array, is_inlined) = (packed >> 63 == 1, packed >> 62 & 1 == 1);
        if packed >> 60 & 1 == 1 {
            // Edits of arrays, of versions to come.
            return Ok(Value::Other);
        }
        let payload = packed & 0xffff_ffff_ffff;
        let low = payload as u32;
        if let Some(format) = arrays::Format::of(kind) {
            return if is_array {
                self.array(&format, payload, packed >> 61 & 1 == 1)
            } else if is_inlined {
                Ok(format.inlined(low))
            } else {
                format.element(&mut self.cursor(payload)?)
            };
        }
        let cursor = || self.cursor(payload);
        Ok(match (kind, is_array) {
            (10, false) => Value::Words(vec![self.string(low)?.to_owned()]),
            (11 | 12, false) => Value::Words(vec![self.token(low)?.to_owned()]),
            (10, true) => self.words(payload, Self::string)?,
            (11 | 12, true) => self.words(payload, Self::token)?,
            (32, _) => Value::Names(self.list(&mut cursor()?, Self::token_item)?),
            (33, _) => Value::Names(self.list(&mut cursor()?, Self::string_item)?),
            (34, _) => Value::Paths(self.list(&mut cursor()?, Self::path_item)?),
            (35, _) => Value::References(self.list(&mut cursor()?, Self::reference_item)?),
            (55, _) => Value::References(self.list(&mut cursor()?, Self::payload_item)?),
            (36..=39, _) => Value::Integers(self.integer_list(kind, &mut cursor()?)?),
            (40, _) => Value::Paths(ListOp::of(self.items(&mut cursor()?, Self::path_item)?)),
            (41, _) => Value::Words(self.items(&mut cursor()?, Self::token_item)?),
            (50, _) => Value::Words(self.items(&mut cursor()?, Self::string_item)?),
            (45, _) => Value::Selections(self.items(&mut cursor()?, Self::selection_item)?),
            (46, _) => Value::Samples(self.samples(cursor()?)?),
            (47, _) => Value::References(ListOp::of(vec![self.payload_item(&mut cursor()?)?])),
            (48, _) => self.doubles(&mut cursor()?)?,
            (49, _) => Value::Offsets(self.items(&mut cursor()?, Self::offset_item)?),
            (51 | 60, _) => Value::Block,
            _ => Value::Other,
        })
    }
}
