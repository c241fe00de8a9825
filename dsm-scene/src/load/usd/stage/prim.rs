//! A composed prim: its opinions by strength.

use std::borrow::Cow;
use std::rc::Rc;

use super::node::{Arc, Map, Node};
use super::{Stage, absolute};
use crate::error::Result;
use crate::load::usd::layer::{PrimSpec, Property, Specifier};
use crate::load::usd::value::{ListOp, Numbers, Stored, TimeOffset, Value};

/// What one layer says of a prim.
#[derive(Clone, Debug)]
struct Opinion {
    layer: usize,
    spec: u32,
    /// The layer's time in the stage's.
    time: TimeOffset,
    maps: Rc<Vec<Map>>,
    path: String,
    is_class: bool,
}

/// A prim of the stage.
#[derive(Clone, Debug)]
pub(in crate::load::usd) struct Prim {
    pub(in crate::load::usd) path: String,
    pub(super) node: Node,
    /// The strongest first.
    opinions: Vec<Opinion>,
}

impl Prim {
    pub(super) fn new(path: String, node: Node) -> Self {
        let (mut opinions, mut weakest) = (Vec::new(), Vec::new());
        flatten(&node, false, false, &mut opinions, &mut weakest);
        opinions.append(&mut weakest);
        Self { path, node, opinions }
    }

    /// How many prims it lies in.
    pub(super) fn depth(&self) -> usize {
        self.path.split('/').filter(|name| !name.is_empty()).count()
    }

    /// The same opinions at the same times: what they say of the prim itself is the same.
    pub(in crate::load::usd) fn key(&self) -> Vec<(usize, u32, [u64; 2])> {
        let key = |opinion: &Opinion| {
            let TimeOffset { offset, scale } = opinion.time;
            (opinion.layer, opinion.spec, [offset.to_bits(), scale.to_bits()])
        };
        self.opinions.iter().map(key).collect()
    }

    fn specs<'a>(
        &'a self,
        stage: &'a Stage<'_>,
    ) -> impl DoubleEndedIterator<Item = (&'a Opinion, &'a PrimSpec)> {
        let spec = |opinion: &'a Opinion| {
            (opinion, &stage.layer(opinion.layer).prims[opinion.spec as usize])
        };
        self.opinions.iter().map(spec)
    }

    fn properties<'a>(
        &'a self,
        stage: &'a Stage<'_>,
        name: &'a str,
    ) -> impl DoubleEndedIterator<Item = (&'a Opinion, &'a Property)> {
        self.specs(stage)
            .filter_map(move |(opinion, spec)| Some((opinion, spec.properties.get(name)?)))
    }

    pub(in crate::load::usd) fn type_name<'a>(&'a self, stage: &'a Stage<'_>) -> &'a str {
        let mut names = self.specs(stage).map(|(_, spec)| spec.type_name.as_str());
        names.find(|name| !name.is_empty()).unwrap_or("")
    }

    pub(in crate::load::usd) fn specifier(&self, stage: &Stage<'_>) -> Specifier {
        let mut inherited = Specifier::Over;
        for (opinion, spec) in self.specs(stage) {
            match spec.specifier {
                Specifier::Over => {}
                // That a class is one is not handed down.
                Specifier::Class if opinion.is_class => inherited = Specifier::Class,
                specifier => return specifier,
            }
        }
        inherited
    }

    /// Names of children, sorted.
    pub(in crate::load::usd) fn child_names(&self, stage: &Stage<'_>) -> Vec<String> {
        let children = self.specs(stage).flat_map(|(_, spec)| &spec.children);
        let mut names: Vec<String> = children.map(|(name, _)| name.clone()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// True if a property has such a name.
    pub(in crate::load::usd) fn has_property(
        &self,
        stage: &Stage<'_>,
        is_named: impl Fn(&str) -> bool,
    ) -> bool {
        self.specs(stage).any(|(_, spec)| spec.properties.keys().any(|name| is_named(name)))
    }

    pub(in crate::load::usd) fn has_field(&self, stage: &Stage<'_>, name: &str) -> bool {
        self.specs(stage).any(|(_, spec)| spec.fields.contains_key(name))
    }

    /// The strongest opinion of a field.
    pub(in crate::load::usd) fn field<'a>(
        &'a self,
        stage: &'a Stage<'_>,
        name: &str,
    ) -> Result<Option<Cow<'a, Value>>> {
        for opinion in &self.opinions {
            if let Some(value) = stage.layer(opinion.layer).field(opinion.spec, name)? {
                return Ok(Some(value));
            }
        }
        Ok(None)
    }

    /// A field that is true or false.
    pub(in crate::load::usd) fn flag(
        &self,
        stage: &Stage<'_>,
        name: &str,
        usual: bool,
    ) -> Result<bool> {
        Ok(match self.field(stage, name)?.as_deref() {
            Some(Value::Numbers(Numbers { data, .. })) => data.first().is_some_and(|&v| v != 0.0),
            _ => usual,
        })
    }

    /// True if all that it holds comes from what it refers to.
    pub(super) fn is_instance(&self, stage: &Stage<'_>) -> Result<bool> {
        Ok(self.node.has_direct(self.depth()) && self.flag(stage, "instanceable", false)?)
    }

    /// A list of whole numbers, edited by all opinions.
    pub(in crate::load::usd) fn integers(&self, stage: &Stage<'_>, name: &str) -> Result<Vec<i64>> {
        let mut list = Vec::new();
        for opinion in self.opinions.iter().rev() {
            if let Some(value) = stage.layer(opinion.layer).field(opinion.spec, name)?
                && let Value::Integers(edit) = value.as_ref()
            {
                edit.apply(&mut list);
            }
        }
        Ok(list)
    }

    /// The interpolation of a primvar.
    pub(in crate::load::usd) fn interpolation<'a>(
        &'a self,
        stage: &'a Stage<'_>,
        name: &'a str,
    ) -> Option<&'a str> {
        self.properties(stage, name).find_map(|(_, property)| property.interpolation.as_deref())
    }

    /// Paths in the stage that a relationship or connection leads to.
    pub(in crate::load::usd) fn targets(
        &self,
        stage: &Stage<'_>,
        name: &str,
    ) -> Result<Vec<String>> {
        let mut targets = Vec::new();
        for (opinion, property) in self.properties(stage, name).rev() {
            let Some(stored) = &property.targets else { continue };
            let value = stage.layer(opinion.layer).value(stored)?;
            let Value::Paths(list) = value.as_ref() else { continue };
            let seen = |path: &String| {
                let path = absolute(path, &opinion.path);
                opinion.maps.iter().try_fold(path, |path, map| map.apply(&path))
            };
            let all = |paths: &Vec<String>| paths.iter().filter_map(seen).collect();
            let list = ListOp {
                explicit: list.explicit.as_ref().map(all),
                prepended: all(&list.prepended),
                appended: all(&list.appended),
                deleted: all(&list.deleted),
            };
            list.apply(&mut targets);
        }
        Ok(targets)
    }

    /// The value of an attribute at a time; without one its default, else its
    /// earliest sample.
    pub(in crate::load::usd) fn attribute(
        &self,
        stage: &Stage<'_>,
        name: &str,
        time: Option<f64>,
    ) -> Result<Option<Value>> {
        let mut earliest = None;
        for (opinion, property) in self.properties(stage, name) {
            let layer = stage.layer(opinion.layer);
            let read = |stored: &Stored| match layer.value(stored)?.into_owned() {
                Value::Block => Ok(None),
                value => Ok(Some(value)),
            };
            if let Some(stored) = &property.samples
                && (time.is_some() || earliest.is_none())
                && let Value::Samples(samples) = layer.value(stored)?.as_ref()
                && !samples.is_empty()
            {
                match time {
                    Some(time) => {
                        return at_time(samples, opinion.time.inside(time), read);
                    }
                    None => earliest = read(&samples[0].1)?,
                }
            }
            if let Some(stored) = &property.default {
                return Ok(match read(stored)? {
                    None if time.is_none() => earliest,
                    value => value,
                });
            }
        }
        Ok(earliest)
    }
}

/// The value between two samples: numbers go linearly, others stay until the next.
fn at_time(
    samples: &[(f64, Stored)],
    time: f64,
    read: impl Fn(&Stored) -> Result<Option<Value>>,
) -> Result<Option<Value>> {
    let after = samples.partition_point(|sample| sample.0 <= time);
    let before = after.saturating_sub(1);
    let value = read(&samples[before].1)?;
    let Some(next) = samples.get(after).filter(|_| after > 0 && samples[before].0 < time) else {
        return Ok(value);
    };
    let part = (time - samples[before].0) / (next.0 - samples[before].0);
    Ok(match (value, read(&next.1)?) {
        (Some(Value::Numbers(from)), Some(Value::Numbers(to))) => {
            Some(Value::Numbers(from.toward(&to, part)))
        }
        (value, _) => value,
    })
}

fn flatten(
    node: &Node,
    is_class: bool,
    is_weak: bool,
    strong: &mut Vec<Opinion>,
    weak: &mut Vec<Opinion>,
) {
    let is_weak = is_weak || node.arc == Arc::Specialize;
    let is_class = is_class || matches!(node.arc, Arc::Inherit | Arc::Specialize);
    for &(layer, spec, time) in &node.specs {
        let opinion = Opinion {
            layer,
            spec,
            time: node.time.around(time),
            maps: Rc::clone(&node.maps),
            path: node.path.clone(),
            is_class,
        };
        if is_weak { weak.push(opinion) } else { strong.push(opinion) }
    }
    for child in &node.children {
        flatten(child, is_class, is_weak, strong, weak);
    }
}
