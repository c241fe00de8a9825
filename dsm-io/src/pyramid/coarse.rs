//! Levels whose pixels are larger than what a tile holds whole.

use dsm_core::Transmittance;
use dsm_core::detail::VisibilityView;

use super::fragment::{Averager, Copies, CopiesBuilder, Fragment, FragmentBuilder};
use super::plan::Plan;
use crate::error::Result;

/// Averages the copies of a node's children into the node's own pixels of the
/// next level, and copies those in turn.
///
/// A pixel's error is the mean of its parts', which counts every error on the
/// way here, and what its own compression adds, measured against the average
/// of its parts.
pub(super) fn average_children<T: Transmittance>(
    plan: &Plan,
    averager: &mut Averager<T>,
    height: u32,
    node: [u32; 2],
    children: &[Copies<T>],
) -> Result<(Fragment<T>, Option<Copies<T>>)> {
    let level = plan.cell_level + height;
    let block = plan.block_size;
    // A node that is there has a pixel in every level.
    let origin = node.map(|index| index.saturating_mul(block));
    let [width, rows] = plan.pyramid.size(level);
    let size = [block.min(width - origin[0]), block.min(rows - origin[1])];
    let mut fragment = FragmentBuilder::new(origin, size, plan.tolerance(level), plan.compression);
    let mut copies = CopiesBuilder::new(size, plan.copy_tolerance(level), plan.compression);
    let mut parts = Vec::new();
    for (row, column) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
        let mut inherited = 0.0;
        parts.clear();
        for (pixel, weight) in plan.pyramid.children(level, [origin[0] + column, origin[1] + row]) {
            let owner = pixel.map(|index| index / block);
            let owner = children.iter().find(|copies| copies.node == owner);
            let function = owner.map_or(VisibilityView::clear(), |copies| {
                let pixels = copies.pixels.view();
                let [x, y] = pixel.map(|index| index % block);
                inherited +=
                    weight * copies.errors[y as usize * pixels.width() as usize + x as usize];
                pixels.pixel(x, y)
            });
            parts.push((weight, function));
        }
        match averager.average(&parts) {
            Some(average) => {
                fragment.push(average, inherited)?;
                copies.push(average, inherited)?;
            }
            // A part that is not quite 1 may have been compressed to that.
            None if inherited > 0.0 => {
                fragment.push(&[], inherited)?;
                copies.push(&[], inherited)?;
            }
            None => {
                fragment.push_clear()?;
                copies.push_clear()?;
            }
        }
    }
    Ok((fragment.finish()?, copies.finish(node)?))
}
