//! The kinds of numbers, and what pixels and vertices tell of those that follow.

/// Number of kinds.
pub(super) const KINDS: usize = OTHER_CHANNEL + 4;

/// The numbers of stations of pixels.
const COUNT: usize = 0;
/// By how much coarser a pixel's grid of corners is.
pub(super) const SHIFT: usize = COUNT + 5;
/// Whether pixels have steps.
pub(super) const HAS_STEPS: usize = SHIFT + 1;
/// Whether stations are steps, of pixels that have some.
const STEP: usize = HAS_STEPS + 1;
/// The depths of first stations.
const FIRST_DEPTH: usize = STEP + 6;
/// The depths of others.
const DEPTH: usize = FIRST_DEPTH + 2;
/// Whether pixels have one channel only.
pub(super) const MONO: usize = DEPTH + 4;
/// Values of the first channel.
const VALUE: usize = MONO + 1;
/// Values of the others.
const OTHER_CHANNEL: usize = VALUE + 6;

/// That of a number of stations, where neighbours have these.
pub(super) const fn count(left: u32, above: u32) -> usize {
    COUNT
        + match (left, above) {
            (0, 0) => 0,
            (0, _) | (_, 0) => 1,
            _ if left + above <= 6 => 2,
            _ if left + above <= 12 => 3,
            _ => 4,
        }
}

/// That of whether a station is a step, from whether the one before it is.
pub(super) const fn step(before: Option<bool>, is_last: bool) -> usize {
    let before = match before {
        None => 0,
        Some(false) => 1,
        Some(true) => 2,
    };
    STEP + 2 * before + is_last as usize
}

/// That of a first station's depth.
pub(super) const fn first_depth(is_step: bool) -> usize {
    FIRST_DEPTH + is_step as usize
}

/// That of another station's depth.
pub(super) const fn depth(is_step: bool, before: bool) -> usize {
    DEPTH + 2 * is_step as usize + before as usize
}

/// What a vertex is within its pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// A corner.
    Corner,
    /// The near side of a step.
    Near,
    /// The far side of a step.
    Far,
    /// The last of the pixel.
    Last,
}

/// That of a value of a channel, where the value before is `before`. But for the last
/// vertex it is known before that value is: a decoder need not wait for it.
pub(super) const fn value(role: Role, channel: usize, before: u32) -> usize {
    if channel > 0 {
        return OTHER_CHANNEL + 2 * (channel - 1) + matches!(role, Role::Last) as usize;
    }
    let size = match role {
        Role::Last if before >= 16 => 2,
        Role::Last if before >= 4 => 1,
        _ => 0,
    };
    VALUE + role as usize + size
}

/// The depth that a pixel's first station is expected at: what the neighbours to the left
/// and above have, or the last pixel that has any.
#[derive(Clone, Debug)]
pub(super) struct FirstDepths {
    width: usize,
    firsts: Vec<Option<u32>>,
    last: u32,
}

impl FirstDepths {
    /// For a tile of this width.
    pub(super) const fn new(width: usize) -> Self {
        Self { width, firsts: Vec::new(), last: 0 }
    }

    /// That of the next pixel.
    pub(super) fn expected(&self) -> u32 {
        let pixel = self.firsts.len();
        let at = |index: Option<usize>| index.and_then(|index| self.firsts[index]);
        let left = if pixel.is_multiple_of(self.width) { None } else { at(pixel.checked_sub(1)) };
        let above = at(pixel.checked_sub(self.width));
        match (left, above) {
            (Some(left), Some(above)) => left.midpoint(above),
            (Some(only), None) | (None, Some(only)) => only,
            (None, None) => self.last,
        }
    }

    /// Goes on to the next pixel.
    pub(super) fn push(&mut self, first: Option<u32>) {
        self.last = first.unwrap_or(self.last);
        self.firsts.push(first);
    }
}

/// The numbers of stations of the neighbours to the left and above.
pub(super) fn neighbours(counts: &[u32], width: usize) -> [u32; 2] {
    let pixel = counts.len();
    let at = |index: Option<usize>| index.map_or(0, |index| counts[index]);
    let left = if pixel.is_multiple_of(width) { 0 } else { at(pixel.checked_sub(1)) };
    [left, at(pixel.checked_sub(width))]
}
