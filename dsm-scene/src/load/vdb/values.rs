//! Values of nodes: their type, their compression, and what stands for those that
//! are not stored.

use half::f16;

use super::blosc;
use super::bytes::Bytes;
use crate::error::Result;

const ZIP: u32 = 1;
const ACTIVE_MASK: u32 = 2;
const BLOSC: u32 = 4;

/// The type of a grid's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueType {
    Float,
    Double,
    Int32,
    Int64,
    Bool,
    /// Nothing but active and inactive.
    Mask,
}

impl ValueType {
    /// The type of a tree of the usual shape, by its name.
    pub(super) fn of_tree(name: &str) -> Option<Self> {
        Some(match name {
            "Tree_float_5_4_3" => Self::Float,
            "Tree_double_5_4_3" => Self::Double,
            "Tree_int32_5_4_3" => Self::Int32,
            "Tree_int64_5_4_3" => Self::Int64,
            "Tree_bool_5_4_3" => Self::Bool,
            "Tree_mask_5_4_3" => Self::Mask,
            _ => return None,
        })
    }

    /// The size of a value that stands alone, in bytes.
    pub(super) const fn size(self) -> usize {
        match self {
            Self::Float | Self::Int32 => 4,
            Self::Double | Self::Int64 => 8,
            Self::Bool | Self::Mask => 1,
        }
    }

    /// A value from its bytes.
    pub(super) fn value(self, bytes: &[u8]) -> f32 {
        fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
            let mut array = [0; N];
            array.copy_from_slice(bytes);
            array
        }
        match self {
            Self::Float => f32::from_le_bytes(array(bytes)),
            Self::Double => f64::from_le_bytes(array(bytes)) as f32,
            Self::Int32 => i32::from_le_bytes(array(bytes)) as f32,
            Self::Int64 => i64::from_le_bytes(array(bytes)) as f32,
            Self::Bool | Self::Mask => f32::from(u8::from(bytes != [0])),
        }
    }

    const fn is_real(self) -> bool {
        matches!(self, Self::Float | Self::Double)
    }
}

/// The storage of a grid's values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Storage {
    pub(super) value_type: ValueType,
    /// Flags of compression.
    pub(super) compression: u32,
    /// True for numbers that are stored as halves.
    pub(super) is_half: bool,
    pub(super) background: f32,
}

/// Reads the flags of a grid's compression.
pub(super) fn read_compression(file: &mut Bytes<'_>) -> Result<u32> {
    match file.u32()? {
        flags if flags <= ZIP | ACTIVE_MASK | BLOSC => Ok(flags),
        flags => Err(file.refuse(format!("unknown compression {flags}"))),
    }
}

/// A bit a place.
#[derive(Clone, Copy)]
pub(super) struct Mask<'a>(&'a [u8]);

impl<'a> Mask<'a> {
    /// The mask of `places` places.
    pub(super) fn read(file: &mut Bytes<'a>, places: usize) -> Result<Self> {
        file.take(places / 8).map(Self)
    }

    /// How many bits are set.
    pub(super) fn count(self) -> usize {
        self.0.iter().map(|byte| byte.count_ones() as usize).sum()
    }

    /// True for a place whose bit is set.
    pub(super) fn has(self, place: usize) -> bool {
        self.0[place / 8] >> (place % 8) & 1 != 0
    }
}

impl Storage {
    /// Reads the values of a node of `places`, of which `active` are active, into
    /// `values`.
    pub(super) fn read(
        &self,
        file: &mut Bytes<'_>,
        places: usize,
        active: Mask<'_>,
        values: &mut Vec<f32>,
    ) -> Result<()> {
        let alone = |file: &mut Bytes<'_>| -> Result<f32> {
            Ok(self.value_type.value(file.take(self.value_type.size())?))
        };
        // What the inactive places hold, if it isn't stored for each.
        let kind = file.u8()?;
        let mut inactive = [self.background; 2];
        match kind {
            0 | 6 => {}
            // Those that are not selected have the sign changed.
            1 | 3 => inactive[0] = self.negated_background(),
            2 | 4 => inactive[0] = alone(file)?,
            5 => inactive = [alone(file)?, alone(file)?],
            _ => return Err(file.refuse("unknown storage of a node's values")),
        }
        let selected = match kind {
            3..=5 => Some(Mask::read(file, places)?),
            _ => None,
        };
        let masked = self.compression & ACTIVE_MASK != 0 && kind != 6;
        let stored = if masked { active.count() } else { places };
        self.read_block(file, stored, values)?;
        if stored < places {
            let active_values = std::mem::take(values);
            let mut next = active_values.into_iter();
            values.extend((0..places).map(|place| {
                if active.has(place) {
                    next.next().unwrap_or_default()
                } else {
                    inactive[usize::from(selected.is_some_and(|mask| mask.has(place)))]
                }
            }));
        }
        Ok(())
    }

    fn negated_background(&self) -> f32 {
        if self.value_type.is_real() { -self.background } else { 1.0 - self.background }
    }

    /// Reads a block of `count` values.
    fn read_block(&self, file: &mut Bytes<'_>, count: usize, values: &mut Vec<f32>) -> Result<()> {
        values.clear();
        let is_half = self.is_half && self.value_type.is_real();
        if is_half && count == 0 {
            // Nothing is written then, no length either.
            return Ok(());
        }
        let size = if is_half { 2 } else { self.value_type.size() };
        let length = count * size;
        let mut unpacked = Vec::new();
        let raw = if self.compression & (BLOSC | ZIP) == 0 {
            file.take(length)?
        } else {
            let packed = file.i64()?;
            if packed <= 0 {
                // Stored as it is, with the length negated.
                if packed.unsigned_abs() != length as u64 {
                    return Err(file.refuse("wrong length of a node's values"));
                }
                file.take(length)?
            } else {
                let place = *file;
                let block = file.take(usize::try_from(packed).unwrap_or(usize::MAX))?;
                unpacked.resize(length, 0);
                self.unpack(block, &mut unpacked).map_err(|reason| place.refuse(reason))?;
                &unpacked
            }
        };
        if is_half {
            values.extend(
                raw.chunks_exact(2).map(|half| f16::from_le_bytes([half[0], half[1]]).to_f32()),
            );
        } else {
            values.extend(raw.chunks_exact(size).map(|bytes| self.value_type.value(bytes)));
        }
        Ok(())
    }

    fn unpack(&self, block: &[u8], output: &mut [u8]) -> std::result::Result<(), blosc::Fault> {
        if output.is_empty() {
            Ok(())
        } else if self.compression & BLOSC != 0 {
            blosc::unpack(block, output)
        } else {
            let length = output.len();
            let blocks = std::iter::once(block);
            match miniz_oxide::inflate::decompress_slice_iter_to_slice(output, blocks, true, false)
            {
                Ok(written) if written == length => Ok(()),
                Ok(_) => Err("wrong length of a compressed block".into()),
                Err(_) => Err("damaged ZIP data".into()),
            }
        }
    }
}
