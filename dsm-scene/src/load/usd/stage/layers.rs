//! Layers, each read once, and stacks of them.

use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

use super::{Arc, Node};
use crate::error::{Error, Place, Result};
use crate::load::read_file;
use crate::load::usd::archive::Archive;
use crate::load::usd::layer::Layer;
use crate::load::usd::location::Location;
use crate::load::usd::value::{TimeOffset, Value};
use crate::load::usd::{binary, text};
use crate::load::warnings::Warnings;

/// Files that a scene may be made of.
const MOST_LAYERS: usize = 4096;

/// A layer with its sublayers, the strongest first, each with its time in the stack's.
pub(super) struct Stack {
    pub(super) root: usize,
    pub(super) layers: Vec<(usize, TimeOffset)>,
    /// Units of time a second.
    pub(super) rate: f64,
}

#[derive(Default)]
pub(super) struct Layers {
    layers: Vec<(Layer, Location)>,
    by_location: HashMap<Location, Option<usize>>,
    archives: HashMap<PathBuf, Rc<Archive>>,
    stacks: Vec<Stack>,
    by_root: HashMap<usize, usize>,
    prims: u64,
    bytes: u64,
}

impl Layers {
    pub(super) fn layer(&self, index: usize) -> &Layer {
        &self.layers[index].0
    }

    pub(super) fn location(&self, index: usize) -> &Location {
        &self.layers[index].1
    }

    pub(super) fn stack(&self, index: usize) -> &Stack {
        &self.stacks[index]
    }

    /// Prims of all layers.
    pub(super) fn prim_count(&self) -> u64 {
        self.prims
    }

    /// Bytes of all layers.
    pub(super) fn byte_count(&self) -> u64 {
        self.bytes
    }

    pub(super) fn open_root(&mut self, location: Location, warnings: &mut Warnings) -> Result<()> {
        let layer = self.read(&location)?;
        self.by_location.insert(location, Some(layer));
        self.stack_of(layer, warnings)?;
        Ok(())
    }

    /// The root of a stack, before anything is composed on it.
    pub(super) fn root_node(&self, stack: usize) -> Node {
        let layers = self.stacks[stack].layers.iter();
        let specs = layers.map(|&(layer, time)| (layer, 0, time)).collect();
        Node { stack, path: "/".to_owned(), specs, ..Node::new(Arc::Root, 0) }
    }

    fn read(&mut self, location: &Location) -> Result<usize> {
        if self.layers.len() >= MOST_LAYERS {
            let (count, limit) = (self.layers.len() as u64 + 1, MOST_LAYERS as u64);
            return Err(Error::TooLarge { what: "layers", count, limit });
        }
        let mut location = location.clone();
        let bytes = match &location.member {
            None => read_file(&location.file)?,
            Some(member) => {
                let archive = match self.archives.get(&location.file) {
                    Some(archive) => Rc::clone(archive),
                    None => {
                        let archive = Rc::new(Archive::read(read_file(&location.file)?)?);
                        self.archives.insert(location.file.clone(), Rc::clone(&archive));
                        archive
                    }
                };
                let name = match member.as_str() {
                    "" => archive.root().unwrap_or_default().to_owned(),
                    member => member.to_owned(),
                };
                let bytes = archive.member(&name).map(<[u8]>::to_vec);
                location.member = Some(name);
                bytes.ok_or_else(|| Error::malformed(Place::Whole, "not in the archive"))?
            }
        };
        self.bytes += bytes.len() as u64;
        let layer = if bytes.starts_with(binary::MAGIC) {
            binary::read(bytes)?
        } else if bytes.starts_with(text::MAGIC) {
            text::read(&bytes)?
        } else {
            let reason = "not a USD file: must begin with #usda or PXR-USDC";
            return Err(Error::malformed(Place::Header, reason));
        };
        self.prims += layer.prims.len() as u64;
        self.layers.push((layer, location));
        Ok(self.layers.len() - 1)
    }

    /// The layer that another one names, if it can be read; a warning if it can't.
    pub(super) fn find(
        &mut self,
        asset: &str,
        from: usize,
        warnings: &mut Warnings,
    ) -> Option<usize> {
        let location = self.location(from).resolve(asset);
        if let Some(&known) = self.by_location.get(&location) {
            return known;
        }
        let found = match self.read(&location) {
            Ok(layer) => Some(layer),
            Err(error) => {
                warnings.add(format!("{asset} is left out: {}", chain(&error)));
                None
            }
        };
        self.by_location.insert(location, found);
        found
    }

    /// The stack whose strongest layer this is.
    pub(super) fn stack_of(&mut self, root: usize, warnings: &mut Warnings) -> Result<usize> {
        if let Some(&stack) = self.by_root.get(&root) {
            return Ok(stack);
        }
        let rate = self.rate(root)?;
        let mut layers = Vec::new();
        self.add_sublayers(root, TimeOffset::NONE, &mut layers, &mut Vec::new(), warnings)?;
        self.stacks.push(Stack { root, layers, rate });
        self.by_root.insert(root, self.stacks.len() - 1);
        Ok(self.stacks.len() - 1)
    }

    fn add_sublayers(
        &mut self,
        layer: usize,
        time: TimeOffset,
        found: &mut Vec<(usize, TimeOffset)>,
        open: &mut Vec<usize>,
        warnings: &mut Warnings,
    ) -> Result<()> {
        // A layer may be there once only.
        if open.contains(&layer) || found.iter().any(|have| have.0 == layer) {
            return Ok(());
        }
        if open.len() > 64 {
            return Err(Error::malformed(Place::Whole, "sublayers are nested too deep"));
        }
        found.push((layer, time));
        open.push(layer);
        let names = match self.layer(layer).field(0, "subLayers")?.map(std::borrow::Cow::into_owned)
        {
            Some(Value::Words(names)) => names,
            _ => Vec::new(),
        };
        let offset = self.layer(layer).field(0, "subLayerOffsets")?;
        let offsets = match offset.map(std::borrow::Cow::into_owned) {
            Some(Value::Offsets(offsets)) => offsets,
            _ => Vec::new(),
        };
        for (index, name) in names.iter().enumerate() {
            let Some(sublayer) = self.find(name, layer, warnings) else { continue };
            let offset = offsets.get(index).copied().unwrap_or(TimeOffset::NONE);
            let own = self.rate(sublayer)?;
            let time = time.around(in_rate(offset, self.rate(layer)?, own));
            self.add_sublayers(sublayer, time, found, open, warnings)?;
        }
        open.pop();
        Ok(())
    }

    /// Units of time a second.
    pub(super) fn rate(&self, layer: usize) -> Result<f64> {
        for name in ["timeCodesPerSecond", "framesPerSecond"] {
            if let Some(value) = self.layer(layer).field(0, name)?
                && let Value::Numbers(numbers) = value.as_ref()
                && let [rate] = numbers.data[..]
                && rate > 0.0
                && rate.is_finite()
            {
                return Ok(rate);
            }
        }
        Ok(24.0)
    }
}

/// An offset around a layer that counts time in another unit.
pub(super) fn in_rate(offset: TimeOffset, outer: f64, inner: f64) -> TimeOffset {
    offset.around(TimeOffset { offset: 0.0, scale: outer / inner })
}

/// An error with its causes.
fn chain(error: &Error) -> String {
    let mut text = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}
