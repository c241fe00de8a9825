//! What a stage draws: surfaces and strands with their places in the world.

mod attributes;
mod collect;
mod cubic;
mod curves;
mod instancer;
mod mesh;
mod xform;

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, Vec3};

use self::attributes::Spread;
use super::layer::Specifier;
use super::stage::{Prim, Stage};
use crate::error::{Error, Place, Result};

pub(super) use self::collect::objects;

/// Prims and copies that may lie in each other.
const MAX_NESTING: usize = 256;
/// Shapes and their copies.
const MOST_ITEMS: usize = 1 << 20;

/// Vertices, triangles and points of all shapes, and of each byte of the files: many
/// prims may have the same array.
const FEW_PRIMITIVES: u64 = 1 << 21;
const MOST_A_BYTE: u64 = 64;

/// A shape in its own space.
#[derive(Debug, PartialEq)]
pub(super) enum Geometry {
    Mesh {
        positions: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        /// One a vertex, or none.
        opacities: Vec<f32>,
    },
    Strands {
        points: Vec<Vec3>,
        radii: Vec<f32>,
        /// One a point, or none.
        opacities: Vec<f32>,
        lengths: Vec<u32>,
    },
}

/// A shape at a place.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub(super) path: Arc<str>,
    pub(super) shape: Arc<Geometry>,
    pub(super) to_world: DAffine3,
    /// The opacity of the whole shape, if it has none of its own.
    pub(super) inherited: Option<f32>,
}

/// What a prim has from those it lies in.
#[derive(Clone)]
struct Inherited {
    to_world: DAffine3,
    opacity: Option<f32>,
    is_drawn: bool,
    nesting: usize,
}

type ShapeKey = Vec<(usize, u32, [u64; 2])>;

/// Whether visibility and purpose of a type count: to the standard, prims without a type
/// have none, and those below them not either.
fn is_imageable(type_name: &str) -> bool {
    !matches!(type_name, "" | "Material" | "Shader" | "NodeGraph")
}

/// Reads a stage.
struct Reader<'s, 'w> {
    stage: &'s mut Stage<'w>,
    time: Option<f64>,
    shapes: HashMap<ShapeKey, Arc<Geometry>>,
    items: Vec<Item>,
    /// Vertices, triangles and points of the shapes.
    primitives: u64,
    /// Types of prims that would be drawn, each with how many there are.
    left_out: Vec<(String, u64)>,
}

/// Everything that a stage draws at a time, prim by prim.
pub(super) fn items(stage: &mut Stage<'_>, time: Option<f64>) -> Result<Vec<Item>> {
    let mut reader = Reader {
        stage,
        time,
        shapes: HashMap::new(),
        items: Vec::new(),
        primitives: 0,
        left_out: Vec::new(),
    };
    let inherited =
        Inherited { to_world: DAffine3::IDENTITY, opacity: None, is_drawn: true, nesting: 0 };
    let root = reader.stage.root();
    reader.visit(&root, &inherited, true)?;
    for (name, count) in std::mem::take(&mut reader.left_out) {
        let line = format!("{count} prims of type {name} are not read and left out");
        reader.stage.warnings.add(line);
    }
    Ok(reader.items)
}

impl Reader<'_, '_> {
    fn push(&mut self, item: Item) -> Result<()> {
        if self.items.len() >= MOST_ITEMS {
            let (count, limit) = (self.items.len() as u64 + 1, MOST_ITEMS as u64);
            return Err(Error::TooLarge { what: "shapes", count, limit });
        }
        self.items.push(item);
        Ok(())
    }

    /// Adds what a prim and those below it draw. A prototype is drawn, whatever its
    /// specifier.
    fn visit(&mut self, prim: &Prim, inherited: &Inherited, is_prototype: bool) -> Result<()> {
        if inherited.nesting > MAX_NESTING {
            return Err(Error::malformed(Place::Whole, "prims are nested too deep"));
        }
        let is_defined = is_prototype || prim.specifier(self.stage) == Specifier::Def;
        if !is_defined || !prim.flag(self.stage, "active", true)? {
            return Ok(());
        }
        let type_name = prim.type_name(self.stage).to_owned();
        if is_imageable(&type_name) && self.word(prim, "visibility", "inherited")? == "invisible" {
            return Ok(());
        }
        let mut own = self.inherited(prim, &type_name, inherited)?;
        own.nesting += 1;
        if prim.has_field(self.stage, "clips") {
            self.stage.warnings.add(format!("{}: value clips are not read", prim.path));
        }
        match type_name.as_str() {
            "Mesh" | "BasisCurves" | "Points" if own.is_drawn => {
                self.shape(prim, &type_name, &own)?;
            }
            "PointInstancer" => {
                // Its prototypes often lie in it, and are not drawn there.
                return if own.is_drawn { self.instancer(prim, &own) } else { Ok(()) };
            }
            "Cube"
            | "Sphere"
            | "Cylinder"
            | "Cylinder_1"
            | "Cone"
            | "Capsule"
            | "Capsule_1"
            | "Plane"
            | "NurbsPatch"
            | "NurbsCurves"
            | "HermiteCurves"
            | "TetMesh"
            | "Volume"
            | "ParticleField3DGaussianSplat"
                if own.is_drawn =>
            {
                match self.left_out.iter_mut().find(|left_out| left_out.0 == type_name) {
                    Some(left_out) => left_out.1 += 1,
                    None => self.left_out.push((type_name.clone(), 1)),
                }
            }
            "Shader" => self.warn_of_shader(prim)?,
            _ => {}
        }
        for name in prim.child_names(self.stage) {
            if let Some(child) = self.stage.child(prim, &name)? {
                self.visit(&child, &own, false)?;
            }
        }
        Ok(())
    }

    /// What the prims below have from this one and those around it.
    fn inherited(&mut self, prim: &Prim, type_name: &str, outer: &Inherited) -> Result<Inherited> {
        let mut own = outer.clone();
        if is_imageable(type_name) && type_name != "Scope" {
            let local = self.local(prim)?;
            own.to_world =
                if local.is_of_world { local.matrix } else { outer.to_world * local.matrix };
        }
        // The nearest prim that says it decides.
        if is_imageable(type_name)
            && let Some(purpose) = attributes::words(prim, self.stage, "purpose", self.time)?
        {
            let purpose = purpose.first().map_or("default", String::as_str);
            own.is_drawn = matches!(purpose, "default" | "render");
        }
        if let Some(opacity) = self.opacity(prim)?
            && opacity.spread == Spread::Constant
        {
            own.opacity = opacity.data.first().map(|&value| value as f32);
        }
        Ok(own)
    }

    fn shape(&mut self, prim: &Prim, type_name: &str, inherited: &Inherited) -> Result<()> {
        let path: Arc<str> = prim.path.as_str().into();
        let key = prim.key();
        let shape = match self.shapes.get(&key) {
            Some(shape) => Arc::clone(shape),
            None => {
                let opacity = self.opacity(prim)?;
                let opacity = opacity.as_ref();
                let shape = Arc::new(match type_name {
                    "Mesh" => self.mesh(prim, opacity)?,
                    "BasisCurves" => self.curves(prim, opacity)?,
                    _ => self.points(prim, opacity)?,
                });
                self.warn_of(prim);
                self.primitives += shape.size();
                let limit = FEW_PRIMITIVES + MOST_A_BYTE * self.stage.byte_count();
                if self.primitives > limit {
                    let (what, count) = ("triangles and points", self.primitives);
                    return Err(Error::TooLarge { what, count, limit });
                }
                self.shapes.insert(key, Arc::clone(&shape));
                shape
            }
        };
        let (Geometry::Mesh { opacities, .. } | Geometry::Strands { opacities, .. }) = &*shape;
        let opacity = if opacities.is_empty() { inherited.opacity } else { None };
        let to_world = inherited.to_world;
        self.push(Item { path, shape, to_world, inherited: opacity })
    }

    /// Says that a material's opacity does not count.
    fn warn_of_shader(&mut self, prim: &Prim) -> Result<()> {
        let name = "inputs:opacity";
        let value = self.numbers(prim, name)?;
        let is_less = value.is_some_and(|value| value.data.iter().any(|&value| value != 1.0));
        if is_less || !prim.targets(self.stage, name)?.is_empty() {
            let line = format!("{}: the opacity of a material does not count", prim.path);
            self.stage.warnings.add(line);
        }
        Ok(())
    }

    /// Says what is not understood and moves points.
    fn warn_of(&mut self, prim: &Prim) {
        let is_skinned = prim.has_property(self.stage, |name| name == "primvars:skel:jointIndices");
        if is_skinned {
            let line = format!("{}: its skeleton does not move it", prim.path);
            self.stage.warnings.add(line);
        }
    }
}
