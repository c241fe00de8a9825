//! Numbers of a PLY file's rows.

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    /// The kind of this name, old or new.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number that `bytes` are, from the lowest.
    fn decode(self, bytes: [u8; 8]) -> f64 {
        let [a, b, c, d, ..] = bytes;
        match self {
            Self::I8 => f64::from(a.cast_signed()),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(bytes),
        }
    }
}

/// The form of the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

impl Encoding {
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "ascii" => Some(Self::Text),
            "binary_little_endian" => Some(Self::LittleEndian),
            "binary_big_endian" => Some(Self::BigEndian),
            _ => None,
        }
    }
}

/// The numbers of the rows, one after the other. Lines of text end where they like.
pub(super) struct Values<'a> {
    rest: &'a [u8],
    encoding: Encoding,
}

impl<'a> Values<'a> {
    pub(super) fn new(rest: &'a [u8], encoding: Encoding) -> Self {
        Self { rest, encoding }
    }

    /// The next number, or a reason why there is none.
    pub(super) fn next(&mut self, kind: Kind) -> Result<f64, &'static str> {
        const END: &str = "the file ends in it";
        if self.encoding == Encoding::Text {
            let text = self.rest.trim_ascii_start();
            let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
            let (word, rest) = text.split_at(end);
            self.rest = rest;
            if word.is_empty() {
                return Err(END);
            }
            let number = text_number(word).ok_or("not a number")?;
            if kind.is_whole() && number.fract() != 0.0 {
                return Err("not a whole number");
            }
            return Ok(number);
        }
        let (value, rest) = self.rest.split_at_checked(kind.size()).ok_or(END)?;
        self.rest = rest;
        let mut bytes = [0; 8];
        bytes[..value.len()].copy_from_slice(value);
        if self.encoding == Encoding::BigEndian {
            bytes[..value.len()].reverse();
        }
        Ok(kind.decode(bytes))
    }

    /// The length of a list, which the rest of the file can hold.
    pub(super) fn length(&mut self, length: Kind, kind: Kind) -> Result<u64, &'static str> {
        let count = self.next(length)?;
        let smallest = if self.encoding == Encoding::Text { 1 } else { kind.size() };
        if count < 0.0 || count.fract() != 0.0 || count * smallest as f64 > self.rest.len() as f64 {
            return Err("the file ends in one of its lists");
        }
        Ok(count as u64)
    }
}

fn text_number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    let unsigned = text.trim_start_matches(['-', '+']);
    // As C libraries write them.
    if unsigned.get(..3).is_some_and(|start| start.eq_ignore_ascii_case("nan")) {
        return Some(f64::NAN);
    }
    text.parse().ok()
}
