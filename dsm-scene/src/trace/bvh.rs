//! The primitives that a ray may meet.
//!
//! The hierarchy works in `f32`, the tests of primitives in `f64`. It must
//! never lose a primitive that is hit. So the object is scaled to [−1, 1]³,
//! where boxes are padded by more than all of the hierarchy's rounding; a ray
//! begins a little before the outer box or its own beginning, so that rounding
//! is relative to the object and not to the way from the camera.

use dsm_core::Ray;
use dsm_core::detail::random::{combine, scattered_seed};
use glam::{DVec3, UVec2};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::{CwBvh, Traversal};
use obvhs::faststack::{FastStack, HeapStack, StackStack};
use obvhs::ploc::PlocBuilder;
use obvhs::ray::Ray as TraversalRay;
use obvhs::{BvhBuildParams, traverse};

use crate::bounds::Bounds;
use crate::error::{Error, Result};

/// The padding of boxes, at least, in an object scaled to [−1, 1]³: rays and boxes
/// there are rounded by a few times 2⁻²⁴.
const PADDING: f64 = 1.0 / (1 << 20) as f64;
/// The distance before its beginning from which a ray is traversed: the hierarchy
/// knows no hits nearer than 10⁻⁴.
const MARGIN: f64 = 1.0 / (1 << 10) as f64;
/// Levels of boxes that the usual stack has room for.
const USUAL_DEPTH: usize = 32;
/// Levels of boxes that are built: what follows works recursively.
const MAX_DEPTH: usize = 2000;

/// A hierarchy of boxes over an object's primitives.
pub(crate) struct Bvh {
    tree: CwBvh,
    depth: usize,
    /// The box in the object's space, and what scales it to [−1, 1]³.
    outer: Bounds,
    scale: f64,
}

/// The state of a traversal, with any stack.
struct State<S> {
    stack: S,
    current_group: UVec2,
    primitive_group: UVec2,
    oct_inv4: u32,
    primitive_id: u32,
    hitmask: u32,
}

impl Bvh {
    /// The hierarchy over one box a primitive; `None` if there are none.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if the boxes nest too deeply, which only boxes do
    /// that were made for it.
    pub(crate) fn new(boxes: &[Bounds]) -> Result<Option<Self>> {
        let outer = boxes.iter().copied().fold(Bounds::default(), Bounds::union);
        if outer.is_empty() {
            return Ok(None);
        }
        let centre = outer.centre();
        let half = (outer.max - outer.min).max_element() / 2.0;
        let scale = if half > 0.0 { half.recip() } else { 1.0 };
        let mut depth = 0;
        // Boxes that are alike would be paired one by one. Padding tells them
        // apart: a little at first, more if that isn't enough.
        for padding in [1.0, 64.0, 4096.0].map(|factor| factor * PADDING) {
            let padded: Vec<Aabb> = (0..)
                .zip(boxes)
                .map(|(index, bounds)| {
                    let pad = |salt| padding * (1.0 + DVec3::from(scatter(index, salt)));
                    let min = (bounds.min - centre) * scale - pad(0);
                    let max = (bounds.max - centre) * scale + pad(1);
                    Aabb::new(min.as_vec3a(), max.as_vec3a())
                })
                .collect();
            let parameters = BvhBuildParams::medium_build();
            let mut pairs = PlocBuilder::with_capacity(padded.len()).build(
                parameters.ploc_search_distance,
                &padded,
                (0..padded.len() as u32).collect(),
                parameters.sort_precision,
                parameters.search_depth_threshold,
            );
            depth = pair_depth(&pairs);
            if depth > MAX_DEPTH {
                continue;
            }
            let ratio = parameters.reinsertion_batch_ratio;
            ReinsertionOptimizer::default().run(&mut pairs, ratio, None);
            let tree =
                bvh2_to_cwbvh(&pairs, parameters.max_prims_per_leaf.clamp(1, 3), true, false);
            let depth = tree_depth(&tree);
            return Ok(Some(Self { tree, depth, outer, scale }));
        }
        let (count, limit) = (depth as u64, MAX_DEPTH as u64);
        Err(Error::TooLarge { what: "levels of boxes within boxes", count, limit })
    }

    /// Calls `test` with every primitive that the part of the ray may meet,
    /// which is given in the object's space, until it returns true. Returns
    /// whether it did.
    pub(crate) fn visit(&self, ray: &Ray, test: impl FnMut(usize) -> bool) -> bool {
        let margin = 4.0 * PADDING / self.scale;
        let padded = Bounds { min: self.outer.min - margin, max: self.outer.max + margin };
        let Some((enter, leave)) = padded.clip(ray.origin(), ray.direction()) else {
            return false;
        };
        let [near, far] = ray.range();
        let (start, end) = (enter.max(near), leave.min(far));
        let Some(direction) = ray.direction().try_normalize() else { return false };
        if start > end {
            return false;
        }
        let length = (end - start) * ray.direction().length() * self.scale;
        let origin = (ray.at(start) - self.outer.centre()) * self.scale - direction * MARGIN;
        let traversal = TraversalRay::new(
            origin.as_vec3a(),
            // The hierarchy takes −0 for a way back in one place and not in
            // another, and then meets nothing.
            direction.as_vec3a() + 0.0,
            0.0,
            (length + MARGIN) as f32 + 8.0 * PADDING as f32,
        );
        if self.depth < USUAL_DEPTH {
            self.walk(&traversal, StackStack::<UVec2, USUAL_DEPTH>::default(), test)
        } else {
            self.walk(&traversal, HeapStack::new_with_capacity(self.depth + 1), test)
        }
    }

    fn walk<S: FastStack<UVec2>>(
        &self,
        ray: &TraversalRay,
        stack: S,
        mut test: impl FnMut(usize) -> bool,
    ) -> bool {
        let Traversal { current_group, primitive_group, oct_inv4, primitive_id, hitmask, .. } =
            self.tree.new_traversal(ray.direction);
        let mut state =
            State { stack, current_group, primitive_group, oct_inv4, primitive_id, hitmask };
        let mut node;
        traverse!(self.tree, node, state, node.intersect_ray(ray, state.oct_inv4), {
            let primitive = self.tree.primitive_indices[state.primitive_id as usize];
            if test(primitive as usize) {
                return true;
            }
        });
        false
    }
}

/// Three numbers in [0, 1) that look random.
fn scatter(index: u32, salt: u32) -> [f64; 3] {
    let bits = scattered_seed(u64::from(index) << 1 | u64::from(salt));
    let bits = combine(bits, bits >> 32);
    [0, 21, 42].map(|shift| ((bits >> shift) & 0x1f_ffff) as f64 / 2_097_152.0)
}

/// Levels of the tree of pairs.
fn pair_depth(pairs: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0_usize, 1)];
    while let Some((index, depth)) = open.pop() {
        deepest = deepest.max(depth);
        if let Some(node) = pairs.nodes.get(index).filter(|node| !node.is_leaf()) {
            let first = node.first_index as usize;
            open.extend([(first, depth + 1), (first + 1, depth + 1)]);
        }
    }
    deepest
}

/// Levels of the wide tree.
fn tree_depth(tree: &CwBvh) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0_usize, 1)];
    while let Some((index, depth)) = open.pop() {
        deepest = deepest.max(depth);
        let node = &tree.nodes[index];
        let inner = (0..8).filter(|&child| !node.is_child_empty(child) && !node.is_leaf(child));
        open.extend(inner.map(|child| (node.child_node_index(child) as usize, depth + 1)));
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_primitive_or_many_alike_are_found() {
        let unit = Bounds { min: DVec3::ZERO, max: DVec3::ONE };
        let ray = Ray::new(DVec3::new(0.5, 0.5, -1e6), DVec3::Z);
        for count in [1, 2, 3, 9, 20_000] {
            let bvh = Bvh::new(&vec![unit; count]).unwrap().unwrap();
            let mut seen = vec![0; count];
            assert!(!bvh.visit(&ray, |index| {
                seen[index] += 1;
                false
            }));
            assert!(seen.iter().all(|&times| times == 1), "{count}");
            let mut first = 0;
            assert!(bvh.visit(&ray, |_| {
                first += 1;
                true
            }));
            assert_eq!(first, 1);
        }
        assert!(Bvh::new(&[]).unwrap().is_none());
    }

    #[test]
    fn flat_boxes_are_found_along_their_plane_and_across() {
        for axis in 0..3 {
            let mut max = DVec3::ONE;
            max[axis] = 0.0;
            let bvh = Bvh::new(&[Bounds { min: DVec3::ZERO, max }; 4]).unwrap().unwrap();
            for direction in 0..3 {
                let mut origin = max * 0.5;
                origin[direction] = -3.0;
                let mut count = 0;
                bvh.visit(&Ray::new(origin, DVec3::AXES[direction]), |_| {
                    count += 1;
                    false
                });
                assert_eq!(count, 4, "plane {axis}, ray {direction}");
            }
        }
    }
}
