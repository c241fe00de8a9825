//! References, payloads, inheritance and variants.

use std::rc::Rc;

use super::layers::in_rate;
use super::node::{Arc, Map, Node};
use super::{Stage, absolute};
use crate::error::{Error, Place, Result};
use crate::load::usd::value::{ListOp, Reference, TimeOffset, Value};

/// References that may lead to each other.
const MAX_NESTING: usize = 64;

/// A reference with the layer that says it.
#[derive(Clone)]
struct Anchored {
    reference: Reference,
    layer: usize,
    time: TimeOffset,
}

impl PartialEq for Anchored {
    fn eq(&self, other: &Self) -> bool {
        self.reference == other.reference
    }
}

impl Stage<'_> {
    /// Adds to a prim's tree what its sites bring in.
    pub(super) fn add_arcs(
        &mut self,
        root: &mut Node,
        depth: usize,
        chosen: &[(String, String)],
    ) -> Result<()> {
        if !self.has_arcs(root) {
            return Ok(());
        }
        let mut choice = chosen.to_vec();
        root.selections(&self.layers, &mut choice)?;
        self.add_targets(root, depth, &choice)?;
        // What came in may choose variants.
        choice.truncate(chosen.len());
        root.selections(&self.layers, &mut choice)?;
        self.add_variants(root, depth, &choice)
    }

    fn has_arcs(&self, node: &Node) -> bool {
        let here = node.specs.iter().any(|&(layer, spec, _)| {
            let prim = &self.layers.layer(layer).prims[spec as usize];
            let names = ["references", "payload", "inheritPaths", "specializes"];
            !prim.variants.is_empty() || names.iter().any(|&name| prim.fields.contains_key(name))
        });
        here || node.children.iter().any(|child| self.has_arcs(child))
    }

    fn add_targets(
        &mut self,
        node: &mut Node,
        depth: usize,
        choice: &[(String, String)],
    ) -> Result<()> {
        for child in &mut node.children {
            self.add_targets(child, depth, choice)?;
        }
        for (arc, name) in [(Arc::Inherit, "inheritPaths"), (Arc::Specialize, "specializes")] {
            for path in self.paths(node, name)? {
                let path = absolute(&path, &node.path);
                let Some(found) = self.index(node.stack, &path, choice)? else { continue };
                self.attach(node, found, arc, depth, TimeOffset::NONE)?;
            }
        }
        for (arc, name) in [(Arc::Reference, "references"), (Arc::Payload, "payload")] {
            for anchored in self.references(node, name)? {
                self.add_reference(node, arc, &anchored, depth, choice)?;
            }
        }
        Ok(())
    }

    fn add_reference(
        &mut self,
        node: &mut Node,
        arc: Arc,
        anchored: &Anchored,
        depth: usize,
        choice: &[(String, String)],
    ) -> Result<()> {
        let Reference { asset, path, offset } = &anchored.reference;
        let (stack, time) = if asset.is_empty() {
            (node.stack, *offset)
        } else {
            let Some(layer) = self.layers.find(asset, anchored.layer, self.warnings) else {
                return Ok(());
            };
            let stack = self.layers.stack_of(layer, self.warnings)?;
            let outer = self.layers.rate(anchored.layer)?;
            let time = in_rate(*offset, outer, self.layers.stack(stack).rate);
            (stack, anchored.time.around(time))
        };
        let path = match path.as_str() {
            "" => self.default_prim(stack)?,
            path => Some(absolute(path, &node.path)),
        };
        let found = match &path {
            Some(path) => self.index(stack, path, choice)?,
            None => None,
        };
        match found {
            Some(found) => self.attach(node, found, arc, depth, time),
            None => {
                let path = path.as_deref().unwrap_or("its default prim");
                let line = format!("{}: {path} of {asset} is not there", node.path);
                self.warnings.add(line.replace(" of  is", " is"));
                Ok(())
            }
        }
    }

    fn default_prim(&self, stack: usize) -> Result<Option<String>> {
        let layer = self.layers.layer(self.layers.stack(stack).root);
        let Some(value) = layer.field(0, "defaultPrim")? else { return Ok(None) };
        Ok(match value.as_ref() {
            Value::Words(words) => words.first().map(|name| absolute(name, "/")),
            _ => None,
        })
    }

    /// Hangs a tree of another prim below a node.
    fn attach(
        &mut self,
        node: &mut Node,
        mut found: Node,
        arc: Arc,
        depth: usize,
        time: TimeOffset,
    ) -> Result<()> {
        self.count(found.count())?;
        let is_open = matches!(arc, Arc::Inherit | Arc::Specialize) || found.stack == node.stack;
        let map = Map::new(&found.path, &node.path, is_open);
        let time = node.time.around(time);
        place(&mut found, &map, node, depth, time);
        node.add(Node { arc, depth, ..found });
        Ok(())
    }

    /// The whole tree of the prim at a path of a stack.
    fn index(
        &mut self,
        stack: usize,
        path: &str,
        choice: &[(String, String)],
    ) -> Result<Option<Node>> {
        let site = (stack, path.to_owned());
        if self.open.contains(&site) {
            self.warnings.add(format!("{path} is composed of itself: that is left out"));
            return Ok(None);
        }
        if self.open.len() >= MAX_NESTING {
            return Err(Error::malformed(Place::Whole, "references are nested too deep"));
        }
        self.open.push(site);
        let names: Vec<&str> = path.split('/').filter(|name| !name.is_empty()).collect();
        let mut node = self.layers.root_node(stack);
        for (at, name) in names.iter().enumerate() {
            let is_last = at + 1 == names.len();
            match self.child_node(&node, name, at + 1, if is_last { choice } else { &[] })? {
                Some(child) => node = child,
                None => {
                    self.open.pop();
                    return Ok(None);
                }
            }
        }
        self.open.pop();
        Ok(Some(node))
    }

    fn add_variants(
        &mut self,
        node: &mut Node,
        depth: usize,
        choice: &[(String, String)],
    ) -> Result<()> {
        for child in &mut node.children {
            // Those of what came in are there already.
            if child.depth != depth || child.arc == Arc::Variant {
                self.add_variants(child, depth, choice)?;
            }
        }
        let mut sets: Vec<String> = Vec::new();
        for &(layer, spec, _) in &node.specs {
            for (set, ..) in &self.layers.layer(layer).prims[spec as usize].variants {
                if !sets.contains(set) {
                    sets.push(set.clone());
                }
            }
        }
        for set in sets {
            let Some((_, name)) = choice.iter().find(|(chosen, _)| *chosen == set) else {
                continue;
            };
            let below = |&(layer, spec, time): &(usize, u32, TimeOffset)| {
                let prim = &self.layers.layer(layer).prims[spec as usize];
                prim.variant(&set, name).map(|variant| (layer, variant, time))
            };
            let specs: Vec<_> = node.specs.iter().filter_map(below).collect();
            if specs.is_empty() {
                continue;
            }
            self.count(1)?;
            let (path, maps) = (node.path.clone(), Rc::clone(&node.maps));
            let mut variant = Node { specs, path, maps, children: Vec::new(), ..*node };
            (variant.arc, variant.depth) = (Arc::Variant, depth);
            self.add_arcs(&mut variant, depth, choice)?;
            node.add(variant);
        }
        Ok(())
    }

    /// A list of paths, edited by all layers of a site.
    fn paths(&self, node: &Node, name: &str) -> Result<Vec<String>> {
        let mut paths = Vec::new();
        for &(layer, spec, _) in node.specs.iter().rev() {
            if let Some(value) = self.layers.layer(layer).field(spec, name)?
                && let Value::Paths(list) = value.as_ref()
            {
                list.apply(&mut paths);
            }
        }
        Ok(paths)
    }

    fn references(&self, node: &Node, name: &str) -> Result<Vec<Anchored>> {
        let mut references = Vec::new();
        for &(layer, spec, time) in node.specs.iter().rev() {
            if let Some(value) = self.layers.layer(layer).field(spec, name)?
                && let Value::References(list) = value.as_ref()
            {
                let anchor = |list: &Vec<Reference>| -> Vec<Anchored> {
                    let of = |reference: &Reference| Anchored {
                        reference: reference.clone(),
                        layer,
                        time,
                    };
                    list.iter().map(of).collect()
                };
                let list = ListOp {
                    explicit: list.explicit.as_ref().map(anchor),
                    prepended: anchor(&list.prepended),
                    appended: anchor(&list.appended),
                    deleted: anchor(&list.deleted),
                };
                list.apply(&mut references);
            }
        }
        Ok(references)
    }
}

/// Moves a tree to where it is seen.
fn place(tree: &mut Node, map: &Map, node: &Node, depth: usize, time: TimeOffset) {
    let maps = Rc::make_mut(&mut tree.maps);
    maps.push(map.clone());
    maps.extend(node.maps.iter().cloned());
    tree.time = time.around(tree.time);
    tree.depth = tree.depth.min(depth);
    for child in &mut tree.children {
        place(child, map, node, depth, time);
    }
}
