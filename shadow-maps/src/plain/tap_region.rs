//! The region of the taps of a percentage closer filter.

use dsm_core::Receiver;

use super::depth_map::DepthMap;

/// A rectangle of texels, cut off at the map's edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TapRegion {
    /// The texel that holds the upper left corner.
    pub(crate) first: [u32; 2],
    /// How far the corner lies into it, in texels: few digits before the point
    /// leave many behind it.
    pub(crate) corner: [f32; 2],
    /// Width and height, in texels.
    pub(crate) extent: [f32; 2],
    /// The last column and row of the map.
    pub(crate) last: [u32; 2],
    /// Texels in a row of the map.
    pub(crate) pitch: u32,
}

/// Depths over a [`TapRegion`]: `corner + across · u + down · v` for (u, v) in
/// [0, 1)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DepthPlane {
    pub(crate) corner: f32,
    pub(crate) across: f32,
    pub(crate) down: f32,
}

impl TapRegion {
    /// The region of `widths` pixels around `receiver`, and the receiver's
    /// depth over it less its bias; `None` where the receiver is lit whatever
    /// the map holds.
    pub(crate) fn around(
        map: &DepthMap,
        receiver: &Receiver,
        widths: [f32; 2],
    ) -> Option<(Self, DepthPlane)> {
        let size = map.size().map(f64::from);
        let position = receiver.position.map(f64::from);
        let inside = (0..2).all(|axis| (0.0..size[axis]).contains(&position[axis]));
        let numbers = [receiver.bias, receiver.depth_gradient[0], receiver.depth_gradient[1]];
        let is_shaded = inside && receiver.depth > 0.0 && numbers.iter().all(|n| !n.is_nan());
        if !is_shaded {
            return None;
        }
        // A NaN becomes 0.
        let half = widths.map(|width| 0.5 * f64::from(width.max(0.0)));
        let start = [0, 1].map(|axis| (position[axis] - half[axis]).max(0.0));
        let end = [0, 1].map(|axis| (position[axis] + half[axis]).min(size[axis]));
        let texels = map.texels();
        let last = texels.map(|count| count - 1);
        let side = f64::from(map.texels_per_side());
        // Texels lie below 2³¹.
        let first = [0, 1].map(|axis| ((start[axis] * side) as u32).min(last[axis]));
        let region = Self {
            first,
            corner: [0, 1].map(|axis| (start[axis] * side - f64::from(first[axis])) as f32),
            extent: [0, 1].map(|axis| ((end[axis] - start[axis]) * side) as f32),
            last,
            pitch: texels[0],
        };
        let slope = receiver.depth_gradient.map(f64::from);
        let to_corner: f64 = (0..2).map(|axis| slope[axis] * (start[axis] - position[axis])).sum();
        let depth = f64::from(receiver.depth) - f64::from(receiver.bias) + to_corner;
        let change = [0, 1].map(|axis| (slope[axis] * (end[axis] - start[axis])) as f32);
        Some((region, DepthPlane { corner: depth as f32, across: change[0], down: change[1] }))
    }
}
