//! What a group of rays from one apex may meet, before its packets look.

use fearless_simd::Simd;

use super::apex::Apex;
use super::cone::Cone;
use super::packet::Packet;
use super::range_tree::{Block, ConeTest, RangeTree, bits};

/// Blocks that a group of rays is narrowed to before its packets look.
const FRONTIER: usize = 6;

/// The blocks that a group of rays from one apex may meet: empty where all are
/// clear.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frontier {
    blocks: Vec<Block>,
    next: Vec<Block>,
}

impl Frontier {
    /// Goes down while the blocks stay few.
    #[inline(always)]
    pub(crate) fn fill<S: Simd>(&mut self, simd: S, tree: &RangeTree, cone: &Cone) {
        self.blocks.clear();
        if cone.is_empty() {
            return;
        }
        let test = ConeTest::new(simd, cone);
        self.blocks.push(tree.root());
        while let Some(first) = self.blocks.first().filter(|block| block.level > 0) {
            let level = first.level;
            self.next.clear();
            for &block in &self.blocks {
                let lanes = tree.overlap(simd, block, &test).lanes;
                self.next.extend(bits(lanes).map(|lane| RangeTree::below(block, lane as u32)));
            }
            if self.next.len() > FRONTIER {
                return;
            }
            std::mem::swap(&mut self.blocks, &mut self.next);
            if level == 1 {
                break;
            }
        }
        // The last word on small groups: are there pixels at all?
        if self.blocks.len() <= 4 && self.blocks.iter().all(|block| block.level == 0) {
            self.blocks.retain(|&block| tree.overlap(simd, block, &test).lanes != 0);
        }
    }

    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }
}

/// The cone of all packets.
pub(crate) fn whole<'a>(packets: impl Iterator<Item = &'a Packet>, apex: &Apex) -> Cone {
    let mut cone = Cone::empty(apex.place, apex.w);
    for packet in packets.filter(|packet| !packet.cone.is_empty()) {
        cone.include(&packet.cone);
    }
    cone
}
