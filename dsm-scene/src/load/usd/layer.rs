//! One file's prims and properties, before composition.

use std::borrow::Cow;
use std::collections::HashMap;

use super::binary::CrateFile;
use super::value::{Stored, Value};
use crate::error::Result;

/// No prim may lie deeper.
pub(super) const MAX_DEPTH: usize = 200;

/// Whether a prim is defined, edits another, or is only there to be inherited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Specifier {
    Def,
    #[default]
    Over,
    Class,
}

/// What one file says of an attribute or a relationship.
#[derive(Debug, Default)]
pub(super) struct Property {
    pub(super) default: Option<Stored>,
    pub(super) samples: Option<Stored>,
    pub(super) interpolation: Option<String>,
    /// Of a relationship, or the sources of an attribute.
    pub(super) targets: Option<Stored>,
}

/// What one file says of a prim, a variant of it, or of the root.
#[derive(Debug, Default)]
pub(super) struct PrimSpec {
    pub(super) specifier: Specifier,
    pub(super) type_name: String,
    pub(super) fields: HashMap<String, Stored>,
    pub(super) properties: HashMap<String, Property>,
    pub(super) children: Vec<(String, u32)>,
    by_name: HashMap<String, u32>,
    /// Set, variant and the index of what it says.
    pub(super) variants: Vec<(String, String, u32)>,
}

impl PrimSpec {
    /// Adds a child, or finds it.
    pub(super) fn child(&self, name: &str) -> Option<u32> {
        self.by_name.get(name).copied()
    }

    pub(super) fn add_child(&mut self, name: &str, index: u32) {
        self.children.push((name.to_owned(), index));
        self.by_name.insert(name.to_owned(), index);
    }

    pub(super) fn variant(&self, set: &str, name: &str) -> Option<u32> {
        self.variants.iter().find(|(s, n, _)| s == set && n == name).map(|&(_, _, at)| at)
    }
}

/// The prims of a file. The first one is the root.
#[derive(Debug)]
pub(super) struct Layer {
    pub(super) prims: Vec<PrimSpec>,
    pub(super) packed: Option<CrateFile>,
}

impl Layer {
    /// The value as it is, or from the file.
    pub(super) fn value<'a>(&self, stored: &'a Stored) -> Result<Cow<'a, Value>> {
        match (stored, &self.packed) {
            (Stored::Read(value), _) => Ok(Cow::Borrowed(value)),
            (Stored::Packed(packed), Some(file)) => Ok(Cow::Owned(file.value(*packed)?)),
            (Stored::Packed(_), None) => Ok(Cow::Owned(Value::Other)),
        }
    }

    /// A field of prim `spec`, if it has it.
    pub(super) fn field(&self, spec: u32, name: &str) -> Result<Option<Cow<'_, Value>>> {
        let stored = self.prims[spec as usize].fields.get(name);
        stored.map(|stored| self.value(stored)).transpose()
    }
}
