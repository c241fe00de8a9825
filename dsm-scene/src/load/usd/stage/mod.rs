//! Composition: what all layers together say of a prim.

mod arcs;
mod layers;
mod node;
mod prim;

pub(super) use self::prim::Prim;

use self::layers::Layers;
use self::node::{Arc, Node};
use super::layer::{Layer, MAX_DEPTH};
use super::location::Location;
use super::value::Value;
use crate::error::{Error, Place, Result};
use crate::load::warnings::Warnings;

/// A file with all that it refers to.
pub(super) struct Stage<'w> {
    layers: Layers,
    pub(super) warnings: &'w mut Warnings,
    /// Sites whose composition is under way, so that none needs itself.
    open: Vec<(usize, String)>,
    /// Opinions composed so far.
    composed: u64,
}

/// Opinions that a scene of few prims may be composed of.
const FEW_OPINIONS: u64 = 1 << 16;
/// Times that a prim's opinions may be composed, on average.
const MOST_COPIES: u64 = 256;

impl<'w> Stage<'w> {
    pub(super) fn open(location: Location, warnings: &'w mut Warnings) -> Result<Self> {
        let mut layers = Layers::default();
        layers.open_root(location, warnings)?;
        Ok(Self { layers, warnings, open: Vec::new(), composed: 0 })
    }

    /// The root, which has no place and no type.
    pub(super) fn root(&self) -> Prim {
        Prim::new("/".to_owned(), self.layers.root_node(0))
    }

    pub(super) fn layer(&self, index: usize) -> &Layer {
        self.layers.layer(index)
    }

    /// Bytes of all layers.
    pub(super) fn byte_count(&self) -> u64 {
        self.layers.byte_count()
    }

    /// A field of the root layer.
    pub(super) fn root_field(&self, name: &str) -> Result<Option<Value>> {
        let layer = self.layers.stack(0).root;
        Ok(self.layers.layer(layer).field(0, name)?.map(std::borrow::Cow::into_owned))
    }

    /// The child `name` of a prim, if anything is said of it.
    pub(super) fn child(&mut self, prim: &Prim, name: &str) -> Result<Option<Prim>> {
        let path = join(&prim.path, name);
        let mut parent = prim.node.clone();
        if prim.is_instance(self)? {
            // What is said of its descendants here does not count.
            parent.keep_direct(prim.depth());
        }
        let node = self.child_node(&parent, name, prim.depth() + 1, &[])?;
        Ok(node.map(|node| Prim::new(path, node)))
    }

    /// The prim at a path.
    pub(super) fn prim(&mut self, path: &str) -> Result<Option<Prim>> {
        let mut prim = self.root();
        for name in path.split('/').filter(|name| !name.is_empty()) {
            match self.child(&prim, name)? {
                Some(child) => prim = child,
                None => return Ok(None),
            }
        }
        Ok(Some(prim))
    }

    fn child_node(
        &mut self,
        parent: &Node,
        name: &str,
        depth: usize,
        chosen: &[(String, String)],
    ) -> Result<Option<Node>> {
        if depth > MAX_DEPTH {
            return Err(Error::malformed(Place::Whole, "prims are nested too deep"));
        }
        let Some(mut node) = parent.child(&self.layers, name) else { return Ok(None) };
        self.count(node.count())?;
        self.add_arcs(&mut node, depth, chosen)?;
        Ok(Some(node))
    }

    /// Counts opinions, which few files may make many of.
    fn count(&mut self, opinions: u64) -> Result<()> {
        self.composed += opinions;
        let limit = FEW_OPINIONS + MOST_COPIES * self.layers.prim_count();
        if self.composed > limit {
            return Err(Error::TooLarge { what: "opinions", count: self.composed, limit });
        }
        Ok(())
    }
}

/// The path of a child.
pub(super) fn join(path: &str, name: &str) -> String {
    if path == "/" { format!("/{name}") } else { format!("{path}/{name}") }
}

/// The path without the variants in it.
fn without_variants(path: &str) -> String {
    let mut plain = String::with_capacity(path.len());
    let mut rest = path;
    while let Some((before, after)) = rest.split_once('{') {
        plain.push_str(before);
        rest = after.split_once('}').map_or("", |(_, rest)| rest);
        if !rest.is_empty() && !rest.starts_with(['/', '.']) && !plain.ends_with('/') {
            plain.push('/');
        }
    }
    plain.push_str(rest);
    plain
}

/// A path seen from a prim: absolute, without the property at its end.
pub(super) fn absolute(path: &str, prim: &str) -> String {
    let path = without_variants(path);
    let path = path.split('.').next().filter(|_| !path.starts_with('.')).unwrap_or(&path);
    if path.starts_with('/') {
        return path.to_owned();
    }
    let mut parts: Vec<&str> = prim.split('/').filter(|part| !part.is_empty()).collect();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    format!("/{}", parts.join("/"))
}
