//! The compressions of chunks, by the identifier in the file.

/// How a part's chunks are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Packing {
    None,
    Rle,
    Zips,
    /// Deep parts only.
    Zstd,
    /// Flat parts only, by the identifier in the file.
    Flat(u8),
}

const NAMES: [&str; 14] = [
    "NONE", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB", "HTJ2K256",
    "HTJ2K32", "HTJ2K", "ZSTD",
];

impl Packing {
    /// The compression with this identifier, of a deep or a flat part; else its
    /// name, and why it is not read.
    pub(crate) fn new(id: u8, deep: bool) -> Result<Self, (String, &'static str)> {
        let reason = match id {
            0 => return Ok(Self::None),
            1 => return Ok(Self::Rle),
            2 => return Ok(Self::Zips),
            13 if deep => return Ok(Self::Zstd),
            3..=5 if !deep => return Ok(Self::Flat(id)),
            3..=9 if deep => "which deep data cannot have: only NONE, RLE, ZIPS and ZSTD are read",
            // The exr crate's decoders overflow (B44), or ask for 2^63 bytes
            // and abort (DWA), on damaged files.
            6..=9 => "which is lossy and not supported: write it again with ZIP or PIZ",
            10..=12 => "which is not supported: use ZIPS, RLE or NONE",
            13 => "which is not supported in flat parts: write it again with ZIP or PIZ",
            _ => "which is unknown",
        };
        let name = NAMES.get(usize::from(id)).map(|&name| name.to_owned());
        Err((name.unwrap_or_else(|| format!("method {id}")), reason))
    }

    pub(crate) fn id(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Rle => 1,
            Self::Zips => 2,
            Self::Zstd => 13,
            Self::Flat(id) => id,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        NAMES.get(usize::from(self.id())).copied().unwrap_or("unknown")
    }

    /// The most unpacked bytes that one packed byte can stand for: deflate
    /// has 258 bytes in two bits, RLE 128 bytes in two bytes, Zstandard a block of
    /// 128 KiB in four; the others are
    /// built from those, or are bounded generously.
    pub(crate) fn expansion(self) -> u64 {
        match self {
            Self::None => 1,
            Self::Rle => 64,
            Self::Zips | Self::Flat(3) => 1032,
            Self::Zstd => 1 << 15,
            Self::Flat(_) => 4096,
        }
    }
}
