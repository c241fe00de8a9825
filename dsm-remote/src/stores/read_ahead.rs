//! What to ask for when a range is read.
//!
//! A read that begins where another ended goes on with its run. What is asked for beyond
//! such a read is at most a quarter of what the run has read, less what it has skipped:
//! bytes that nobody wants are never more than a quarter of those that were read,
//! wherever the reader skips or stops.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use super::block::Block;

/// Runs that are followed at once: threads that each go through a part of a file, and
/// rows of tiles that a file has in another order.
const RUNS: usize = 256;
/// The most bytes that the runs have at hand together, but for the one used last.
const HELD_BYTES: u64 = 32 << 20;

/// Reads that follow each other.
#[derive(Debug)]
struct Run {
    /// Where the last ended.
    end: u64,
    /// Bytes that were read.
    read: u64,
    /// Bytes that were asked for and passed over.
    skipped: u64,
    /// Bytes at hand from the last request on.
    block: Arc<Block>,
}

/// How a range is read: from these blocks, one after the other, the last of which may
/// have to be fetched.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) blocks: Vec<Arc<Block>>,
    pub(super) fetch: Option<Arc<Block>>,
}

/// The runs of a file's reads, the one used last in front.
#[derive(Debug)]
pub(super) struct ReadAhead {
    runs: VecDeque<Run>,
    length: u64,
    most: u64,
}

impl ReadAhead {
    /// Of a file of `length` bytes: at most `most` bytes ahead of a read.
    pub(super) const fn new(length: u64, most: u64) -> Self {
        Self { runs: VecDeque::new(), length, most }
    }

    /// How to read a range that lies in the file.
    pub(super) fn plan(&mut self, range: &Range<u64>) -> Plan {
        let continues = |run: &Run| {
            let at_hand = run.block.range();
            // Within the bytes at hand, which the reader may have skipped some of.
            (at_hand.start..=at_hand.end).contains(&range.start)
        };
        let Some(index) = self.runs.iter().position(continues) else {
            return self.begin(range);
        };
        let Some(mut run) = self.runs.remove(index) else { return self.begin(range) };
        let at_hand = run.block.range().clone();
        run.skipped += range.start.saturating_sub(run.end);
        run.read += range.end.saturating_sub(run.end.max(range.start));
        run.end = run.end.max(range.end);
        let plan = if range.end <= at_hand.end {
            Plan { blocks: vec![Arc::clone(&run.block)], fetch: None }
        } else {
            let ahead = (run.read / 4).saturating_sub(run.skipped).min(self.most);
            let end = range.end.saturating_add(ahead).min(self.length);
            let next = Arc::new(Block::new(at_hand.end..end));
            let old = std::mem::replace(&mut run.block, Arc::clone(&next));
            let rest = (range.start < at_hand.end).then_some(old);
            Plan {
                blocks: rest.into_iter().chain([Arc::clone(&next)]).collect(),
                fetch: Some(next),
            }
        };
        self.put(run);
        plan
    }

    /// Puts a run in front, and lets those go that were not used for longest.
    fn put(&mut self, run: Run) {
        self.runs.push_front(run);
        self.runs.truncate(RUNS);
        let mut held = 0;
        let fits = |run: &Run| {
            let range = run.block.range();
            held += range.end - range.start;
            held <= HELD_BYTES
        };
        let kept = self.runs.iter().map(fits).take_while(|&fits| fits).count();
        self.runs.truncate(kept.max(1));
    }

    fn begin(&mut self, range: &Range<u64>) -> Plan {
        let block = Arc::new(Block::new(range.clone()));
        let read = range.end - range.start;
        let run = Run { end: range.end, read, skipped: 0, block: Arc::clone(&block) };
        self.put(run);
        Plan { blocks: vec![Arc::clone(&block)], fetch: Some(block) }
    }

    /// Forgets a block that could not be read.
    pub(super) fn forget(&mut self, block: &Arc<Block>) {
        self.runs.retain(|run| !Arc::ptr_eq(&run.block, block));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads ranges, and says which were asked for.
    fn ask(file: &mut ReadAhead, range: Range<u64>) -> Option<Range<u64>> {
        let plan = file.plan(&range);
        // Whatever is planned, the blocks make up the range.
        let mut next = range.start;
        for block in &plan.blocks {
            assert!(block.range().contains(&next), "{range:?} {plan:?}");
            next = block.range().end.min(range.end);
        }
        assert_eq!(next, range.end);
        plan.fetch.map(|block| block.range().clone())
    }

    #[test]
    fn a_scan_takes_few_requests_and_little_more_than_it_reads() {
        let (tile, tiles) = (1000, 2000);
        let mut file = ReadAhead::new(u64::MAX, 100_000);
        let (mut requests, mut bytes) = (0, 0);
        for index in 0..tiles {
            if let Some(range) = ask(&mut file, index * tile..(index + 1) * tile) {
                requests += 1;
                bytes += range.end - range.start;
            }
            assert!(bytes <= (index + 1) * tile * 5 / 4, "tile {index}: {bytes}");
        }
        assert!(requests <= 50, "{requests}");
    }

    #[test]
    fn reads_anywhere_take_what_they_ask_for() {
        let mut file = ReadAhead::new(u64::MAX, 100_000);
        for index in 0..1000_u64 {
            let start = (index * 7919 % 1000) * 3000;
            assert_eq!(ask(&mut file, start..start + 1000), Some(start..start + 1000));
        }
    }

    #[test]
    fn nothing_is_asked_for_behind_the_end_or_without_leave() {
        let mut file = ReadAhead::new(2100, 1000);
        assert_eq!(ask(&mut file, 0..1000), Some(0..1000));
        assert_eq!(ask(&mut file, 1000..2000), Some(1000..2100));
        assert_eq!(ask(&mut file, 2000..2100), None);
        let mut file = ReadAhead::new(u64::MAX, 0);
        for index in 0..10 {
            let range = index * 10..(index + 1) * 10;
            assert_eq!(ask(&mut file, range.clone()), Some(range));
        }
    }

    #[test]
    fn threads_that_scan_parts_each_have_their_run() {
        let mut file = ReadAhead::new(u64::MAX, 1 << 20);
        const THREADS: u64 = 8;
        let (mut requests, mut bytes) = (0, 0);
        for step in 0..100_u64 {
            for thread in 0..THREADS {
                let start = thread * (1 << 40) + step * 1000;
                if let Some(range) = ask(&mut file, start..start + 1000) {
                    requests += 1;
                    bytes += range.end - range.start;
                }
            }
        }
        assert!(requests < THREADS * 30, "{requests}");
        assert!(bytes <= 100_000 * THREADS * 5 / 4, "{bytes}");
    }

    #[test]
    fn what_is_at_hand_is_bounded() {
        let mut file = ReadAhead::new(u64::MAX, 4 << 20);
        for index in 0..1000_u64 {
            let range = index << 40..(index << 40) + (1 << 20);
            ask(&mut file, range);
            let held = file.runs.iter().map(|run| run.block.range().end - run.block.range().start);
            assert!(held.sum::<u64>() <= HELD_BYTES);
        }
        ask(&mut file, 1 << 60..(1 << 60) + (64 << 20));
        assert_eq!(file.runs.len(), 1);
        for index in 0..1000_u64 {
            ask(&mut file, index << 40..(index << 40) + 1);
            assert!(file.runs.len() <= RUNS);
        }
    }

    #[test]
    fn a_reader_that_skips_wastes_no_more_than_one_that_stops() {
        for stride in 2..9_u64 {
            let mut file = ReadAhead::new(u64::MAX, 1 << 30);
            let (mut read, mut bytes) = (0, 0);
            for index in 0..3000_u64 {
                // A run first, which earns the right to read ahead, and then every few.
                let tile = if index < 1000 { index } else { 1000 + (index - 1000) * stride };
                if let Some(range) = ask(&mut file, tile * 100..(tile + 1) * 100) {
                    bytes += range.end - range.start;
                }
                read += 100;
                assert!(bytes <= read * 5 / 4, "every {stride}th, {index}: {bytes} of {read}");
            }
        }
    }
}
