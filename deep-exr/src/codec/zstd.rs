//! ZSTD chunks, as OpenEXR 3.5 defines them.
//!
//! Values are put in order (those of two bytes before those of four, row by row,
//! channel by channel), their bytes into planes, and that into a Zstandard frame
//! after a header of 24 bytes.

use std::ops::Range;

use ruzstd::decoding::FrameDecoder;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

const MAGIC: &[u8; 8] = b"zstd-exr";
const HEADER: usize = 24;
/// Values are sorted and shuffled; a second version may store differences.
const SORTED: u32 = 1;

/// What a chunk's bytes are: the rows of every channel, one after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleGrid<'a> {
    /// Number of samples in each row.
    pub(crate) row_samples: &'a [u32],
    /// 16-bit words of a value, of each channel.
    pub(crate) channel_words: &'a [usize],
}

impl SampleGrid<'_> {
    fn words_per_sample(&self) -> usize {
        self.channel_words.iter().sum()
    }

    /// Calls `at` with the words of each run of values of `words` each, row by row,
    /// channel by channel.
    fn runs(&self, words: usize, mut at: impl FnMut(Range<usize>)) {
        let mut start = 0;
        for &samples in self.row_samples {
            for &own in self.channel_words {
                let end = start + samples as usize * own;
                if own == words {
                    at(start..end);
                }
                start = end;
            }
        }
    }

    /// Words of all values of `words` each.
    fn sorted_words(&self, words: usize) -> usize {
        let mut sum = 0;
        self.runs(words, |run| sum += run.len());
        sum
    }

    /// Words of all values.
    pub(crate) fn total_words(&self) -> usize {
        self.row_samples.iter().map(|&samples| samples as usize).sum::<usize>()
            * self.words_per_sample()
    }
}

/// Unpacks a chunk into `words`, as many as the grid has; `inner` is memory to use.
pub(crate) fn unpack(
    packed: &[u8],
    grid: &SampleGrid<'_>,
    inner: &mut Vec<u8>,
    words: &mut [u16],
) -> Result<(), String> {
    let number = |at: usize| -> Option<u64> {
        Some(u64::from_le_bytes(packed.get(at..at + 8)?.try_into().ok()?))
    };
    let (true, Some(format), Some(length)) = (packed.starts_with(MAGIC), number(8), number(16))
    else {
        return Err("no header of ZSTD".to_owned());
    };
    if format != u64::from(SORTED) {
        let (version, flags) = (format as u32, format >> 32);
        return Err(format!("unsupported form {version} of ZSTD, with flags {flags}"));
    }
    let frame = &packed[HEADER..];
    if length != frame.len() as u64 {
        return Err(format!("a frame of {length} bytes, in {}", frame.len()));
    }
    let sections = sections(grid);
    let expected: usize = sections.iter().map(|(_, bytes)| 8 + bytes).sum();
    inner.clear();
    inner.resize(expected, 0);
    let unpacked = FrameDecoder::new()
        .decode_all(frame, inner)
        .map_err(|error| format!("malformed ZSTD frame: {error}"))?;
    if unpacked != expected {
        return Err(format!("{} bytes of ZSTD unpack to {unpacked}, not {expected}", packed.len()));
    }
    let mut rest = inner.as_slice();
    for (value_words, bytes) in sections {
        let (stated, planes) = rest.split_at(8);
        let (planes, after) = planes.split_at(bytes);
        rest = after;
        if stated != (bytes as u64).to_le_bytes() {
            return Err("wrong length of a section of ZSTD".to_owned());
        }
        let values = bytes / (2 * value_words);
        let mut next = 0;
        grid.runs(value_words, |run| {
            for word in words[run].chunks_exact_mut(value_words) {
                for (half, word) in word.iter_mut().enumerate() {
                    let low = planes[2 * half * values + next];
                    let high = planes[(2 * half + 1) * values + next];
                    *word = u16::from_le_bytes([low, high]);
                }
                next += 1;
            }
        });
    }
    Ok(())
}

/// Packs the bytes of a chunk with this grid.
pub(crate) fn pack(bytes: &[u8], grid: &SampleGrid<'_>, packed: &mut Vec<u8>) {
    let mut inner = Vec::with_capacity(bytes.len() + 16);
    for (value_words, length) in sections(grid) {
        inner.extend((length as u64).to_le_bytes());
        let size = 2 * value_words;
        for plane in 0..size {
            grid.runs(value_words, |run| {
                let values = &bytes[2 * run.start..2 * run.end];
                inner.extend(values.iter().skip(plane).step_by(size));
            });
        }
    }
    let frame = compress_to_vec(inner.as_slice(), CompressionLevel::Fastest);
    packed.extend(MAGIC);
    packed.extend(SORTED.to_le_bytes());
    packed.extend(0_u32.to_le_bytes());
    packed.extend((frame.len() as u64).to_le_bytes());
    packed.extend(frame);
}

/// The words of a value and the bytes of each section: values of two bytes and of
/// four, or those that there are.
fn sections(grid: &SampleGrid<'_>) -> Vec<(usize, usize)> {
    let sections = [1, 2].map(|words| (words, 2 * grid.sorted_words(words)));
    sections.into_iter().filter(|(_, bytes)| *bytes > 0).collect()
}
