//! The width of everything that is tested at once.

/// Children of a node, and rays of a packet.
pub(crate) const LANES: usize = 16;
