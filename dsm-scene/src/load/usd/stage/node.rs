//! Sites that a prim is composed of, as a tree.

use std::cmp::Reverse;
use std::rc::Rc;

use super::join;
use super::layers::Layers;
use crate::error::Result;
use crate::load::usd::value::{TimeOffset, Value};

/// Why a site counts, the strongest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Arc {
    Root,
    Inherit,
    Variant,
    Reference,
    Payload,
    Specialize,
}

/// A renaming of paths: what lies at `from` is seen at `to`.
#[derive(Clone, Debug)]
pub(super) struct Map {
    from: String,
    to: String,
    /// True if paths elsewhere stay as they are.
    is_open: bool,
}

impl Map {
    pub(super) fn new(from: &str, to: &str, is_open: bool) -> Self {
        Self { from: from.to_owned(), to: to.to_owned(), is_open }
    }

    pub(super) fn apply(&self, path: &str) -> Option<String> {
        match path.strip_prefix(&self.from) {
            Some("") => Some(self.to.clone()),
            Some(rest) if rest.starts_with('/') => Some(format!("{}{rest}", self.to)),
            _ => self.is_open.then(|| path.to_owned()),
        }
    }
}

/// What the layers of a stack say at a path, and what follows from that.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) arc: Arc,
    /// How deep in the stage the prim lies that brought it in.
    pub(super) depth: usize,
    pub(super) stack: usize,
    /// In the stack, without variants.
    pub(super) path: String,
    /// Layer, prim and the layer's time in the stack's, the strongest first.
    pub(super) specs: Vec<(usize, u32, TimeOffset)>,
    /// The stack's time in the stage's.
    pub(super) time: TimeOffset,
    /// From the stack's paths to the stage's, one after the other.
    pub(super) maps: Rc<Vec<Map>>,
    /// The strongest first.
    pub(super) children: Vec<Self>,
}

impl Node {
    pub(super) fn new(arc: Arc, depth: usize) -> Self {
        let (specs, maps, children) = (Vec::new(), Rc::default(), Vec::new());
        Self {
            arc,
            depth,
            stack: 0,
            path: String::new(),
            specs,
            time: TimeOffset::NONE,
            maps,
            children,
        }
    }

    /// The same tree one name further down, without what says nothing there.
    pub(super) fn child(&self, layers: &Layers, name: &str) -> Option<Self> {
        let below = |&(layer, spec, time): &(usize, u32, TimeOffset)| {
            let prims = &layers.layer(layer).prims;
            prims[spec as usize].child(name).map(|child| (layer, child, time))
        };
        let specs: Vec<_> = self.specs.iter().filter_map(below).collect();
        let children: Vec<_> =
            self.children.iter().filter_map(|child| child.child(layers, name)).collect();
        if specs.is_empty() && children.is_empty() {
            return None;
        }
        let maps = Rc::clone(&self.maps);
        Some(Self { path: join(&self.path, name), specs, maps, children, ..*self })
    }

    /// Adds a child among the others by its strength.
    pub(super) fn add(&mut self, child: Self) {
        let strength = |node: &Self| (node.arc, Reverse(node.depth));
        let weaker = self.children.iter().position(|other| strength(other) > strength(&child));
        self.children.insert(weaker.unwrap_or(self.children.len()), child);
    }

    /// Calls `visit` for this node and those below, the strongest first.
    pub(super) fn visit<'a>(
        &'a self,
        visit: &mut impl FnMut(&'a Self) -> Result<()>,
    ) -> Result<()> {
        visit(self)?;
        self.children.iter().try_for_each(|child| child.visit(visit))
    }

    pub(super) fn count(&self) -> u64 {
        1 + self.children.iter().map(Self::count).sum::<u64>()
    }

    /// True if the prim itself brought anything in.
    pub(super) fn has_direct(&self, depth: usize) -> bool {
        self.children.iter().any(|child| child.depth == depth || child.has_direct(depth))
    }

    /// Keeps only what the prim at this depth brought in itself.
    pub(super) fn keep_direct(&mut self, depth: usize) {
        self.specs.clear();
        self.children.retain(|child| child.depth == depth || child.has_direct(depth));
        for child in self.children.iter_mut().filter(|child| child.depth != depth) {
            child.keep_direct(depth);
        }
    }

    /// Variants that are chosen here, the strongest choice first.
    pub(super) fn selections(
        &self,
        layers: &Layers,
        chosen: &mut Vec<(String, String)>,
    ) -> Result<()> {
        self.visit(&mut |node| {
            for &(layer, spec, _) in &node.specs {
                if let Some(value) = layers.layer(layer).field(spec, "variantSelection")?
                    && let Value::Selections(selections) = value.as_ref()
                {
                    chosen.extend(selections.iter().cloned());
                }
            }
            Ok(())
        })
    }
}
