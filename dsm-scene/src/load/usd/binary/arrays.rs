//! Numbers in binary files: alone, inlined, and in arrays.

use half::f16;

use super::CrateFile;
use super::compressed::integers;
use super::cursor::Cursor;
use crate::error::Result;
use crate::load::usd::value::{Between, Numbers, Value};

/// Shorter arrays are never compressed.
const SHORTEST_COMPRESSED: u64 = 16;

/// Numbers that an array may have a byte of the file: the shortest codes take two
/// bits, in blocks that LZ4 makes smaller, but an array alone is no geometry.
const MOST_NUMBERS: u64 = 16;

#[derive(Clone, Copy, PartialEq)]
enum Number {
    Bool,
    Byte,
    Int,
    Uint,
    Int64,
    Uint64,
    Half,
    Float,
    Double,
}

/// How elements of a type are stored.
pub(super) struct Format {
    number: Number,
    size: usize,
    is_matrix: bool,
    between: Between,
}

impl Format {
    /// The format of type `kind`, if it is of numbers.
    pub(super) fn of(kind: u8) -> Option<Self> {
        use Number::{Bool, Byte, Double, Float, Half, Int, Int64, Uint, Uint64};
        let (number, size) = match kind {
            1 => (Bool, 1),
            2 => (Byte, 1),
            3 => (Int, 1),
            4 => (Uint, 1),
            5 => (Int64, 1),
            6 => (Uint64, 1),
            7 => (Half, 1),
            8 => (Float, 1),
            9 | 56 => (Double, 1),
            13 => (Double, 4),
            14 => (Double, 9),
            15 => (Double, 16),
            16 => (Double, 4),
            17 => (Float, 4),
            18 => (Half, 4),
            19..=30 => {
                let number = [Double, Float, Half, Int][(kind - 19) as usize % 4];
                (number, 2 + (kind - 19) as usize / 4)
            }
            _ => return None,
        };
        let between = match (kind, number) {
            (16..=18, _) => Between::Arc,
            (_, Half | Float | Double) => Between::Line,
            _ => Between::Step,
        };
        Some(Self { number, size, is_matrix: matches!(kind, 13..=15), between })
    }

    fn bytes(&self) -> u64 {
        let number: u64 = match self.number {
            Number::Bool | Number::Byte => 1,
            Number::Half => 2,
            Number::Int | Number::Uint | Number::Float => 4,
            Number::Int64 | Number::Uint64 | Number::Double => 8,
        };
        number * self.size as u64
    }

    fn number(&self, cursor: &mut Cursor<'_>) -> Result<f64> {
        Ok(match self.number {
            Number::Bool | Number::Byte => cursor.u8()?.into(),
            Number::Half => f16::from_le_bytes(cursor.array()?).into(),
            Number::Int => (cursor.u32()? as i32).into(),
            Number::Uint => cursor.u32()?.into(),
            Number::Float => f32::from_le_bytes(cursor.array()?).into(),
            Number::Int64 => cursor.u64()? as i64 as f64,
            Number::Uint64 => cursor.u64()? as f64,
            Number::Double => cursor.f64()?,
        })
    }

    pub(super) fn element(&self, cursor: &mut Cursor<'_>) -> Result<Value> {
        let data = (0..self.size).map(|_| self.number(cursor)).collect::<Result<_>>()?;
        Ok(Value::Numbers(Numbers {
            size: self.size,
            is_array: false,
            between: self.between,
            data,
        }))
    }

    /// The element in the 32 bits of a value that needs no place of its own.
    pub(super) fn inlined(&self, bits: u32) -> Value {
        let small = bits.to_le_bytes().map(|byte| f64::from(byte as i8));
        let data = match (self.size, self.number) {
            (1, Number::Int | Number::Int64) => vec![f64::from(bits as i32)],
            (1, Number::Float | Number::Double) => vec![f32::from_bits(bits).into()],
            (1, Number::Half) => vec![f16::from_bits(bits as u16).into()],
            (1, Number::Bool | Number::Byte) => vec![f64::from(bits as u8)],
            (1, Number::Uint | Number::Uint64) => vec![bits.into()],
            // A vector of small integers, or a matrix with a diagonal of them.
            (2..=4, _) if !self.is_matrix => small[..self.size].to_vec(),
            _ => {
                let side = self.size.isqrt();
                let mut matrix = vec![0.0; self.size];
                for (row, value) in small.into_iter().enumerate().take(side) {
                    matrix[row * (side + 1)] = value;
                }
                matrix
            }
        };
        Value::Numbers(Numbers { size: self.size, is_array: false, between: self.between, data })
    }
}

impl CrateFile {
    pub(super) fn array_length(&self, cursor: &mut Cursor<'_>) -> Result<u64> {
        if self.version < [0, 5, 0] {
            // The number of dimensions: always 1.
            cursor.u32()?;
        }
        if self.version < [0, 7, 0] { cursor.u32().map(u64::from) } else { cursor.u64() }
    }

    /// The array at a place of the file; none is at 0.
    pub(super) fn array(&self, format: &Format, at: u64, is_compressed: bool) -> Result<Value> {
        let (size, between) = (format.size, format.between);
        let made = |data| Value::Numbers(Numbers { size, is_array: true, between, data });
        if at == 0 {
            return Ok(made(Vec::new()));
        }
        let mut cursor = self.cursor(at)?;
        let count = self.array_length(&mut cursor)?;
        if count > MOST_NUMBERS.saturating_mul(self.bytes.len() as u64) {
            return Err(cursor.error("an array is longer than the file"));
        }
        if is_compressed && count >= SHORTEST_COMPRESSED && size == 1 {
            return self.compressed(format, count, &mut cursor).map(made);
        }
        if count > cursor.left() as u64 / format.bytes() {
            return Err(cursor.error("an array is longer than the file"));
        }
        let count = count as usize * size;
        let mut data = Vec::with_capacity(count);
        for _ in 0..count {
            data.push(format.number(&mut cursor)?);
        }
        Ok(made(data))
    }

    fn compressed(&self, format: &Format, count: u64, cursor: &mut Cursor<'_>) -> Result<Vec<f64>> {
        let numbers = |integers: Vec<i64>| integers.into_iter().map(|value| value as f64).collect();
        match format.number {
            Number::Int => integers(cursor, count, 4).map(numbers),
            Number::Uint => {
                let unsigned = |value: i64| f64::from(value as u32);
                Ok(integers(cursor, count, 4)?.into_iter().map(unsigned).collect())
            }
            Number::Int64 | Number::Uint64 => integers(cursor, count, 8).map(numbers),
            Number::Half | Number::Float | Number::Double => match cursor.u8()? {
                b'i' => integers(cursor, count, 4).map(numbers),
                b't' => {
                    let length = cursor.u32()?;
                    if u64::from(length) > cursor.left() as u64 / format.bytes() {
                        return Err(cursor.error("a table is longer than the file"));
                    }
                    let table =
                        (0..length).map(|_| format.number(cursor)).collect::<Result<Vec<f64>>>()?;
                    let look_up = |index: i64| {
                        let value = table.get(index as u32 as usize).copied();
                        value.ok_or_else(|| cursor.error("a table is too short"))
                    };
                    let indices = integers(&mut { *cursor }, count, 4)?;
                    indices.into_iter().map(look_up).collect()
                }
                _ => Err(cursor.error("an array is compressed in an unknown way")),
            },
            Number::Bool | Number::Byte => {
                Err(cursor.error("an array is compressed in an unknown way"))
            }
        }
    }
}
