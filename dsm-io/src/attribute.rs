//! Free attributes, kept bit for bit.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use serde_json::Value;

/// A value with the name of its type, as OpenEXR headers have them. It is
/// kept as the bytes that OpenEXR stores, little endian.
///
/// In JSON the types `string`, `int`, `float`, `double`, `v2i`, `v2f`, `v2d`,
/// `v3i`, `v3f`, `v3d`, `box2i`, `box2f`, `m33f`, `m33d`, `m44f`, `m44d` and
/// `chromaticities` are readable (`{"type": "v2i", "value": [1, 2]}`) where
/// that loses nothing; everything else, and NaN and text that is not UTF-8,
/// is in hexadecimal digits (`{"type": "preview", "hex": "00ff"}`).
///
/// ```
/// use dsm_io::Attribute;
///
/// assert_eq!(Attribute::string("rim light").as_text(), Some("rim light"));
/// assert_eq!(Attribute::new("int", 7_i32.to_le_bytes()).bytes(), [7, 0, 0, 0]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attribute {
    type_name: String,
    bytes: Vec<u8>,
}

impl Attribute {
    /// An attribute of the type `type_name` with these bytes.
    #[must_use]
    pub fn new(type_name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { type_name: type_name.into(), bytes: bytes.into() }
    }

    /// An attribute that holds text.
    #[must_use]
    pub fn string(text: &str) -> Self {
        Self::new("string", text)
    }

    /// The name of the attribute's type.
    #[must_use]
    pub fn type_name(&self) -> &str {
        &self.type_name
    }

    /// The bytes of its value.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The text of a `string` in UTF-8.
    #[must_use]
    pub fn as_text(&self) -> Option<&str> {
        (self.type_name == "string").then(|| std::str::from_utf8(&self.bytes).ok())?
    }

    /// The value in a form that people can read, if that loses nothing.
    fn readable(&self) -> Option<Value> {
        if self.type_name == "string" {
            return self.as_text().map(Value::from);
        }
        let (number, count) = numbers(&self.type_name)?;
        let size = number.size();
        if self.bytes.len() != count * size {
            return None;
        }
        let values = self.bytes.chunks_exact(size).map(|bytes| number.read(bytes));
        let mut values = values.collect::<Option<Vec<_>>>()?;
        if count == 1 { values.pop() } else { Some(values.into()) }
    }

    /// The attribute that [`Self::readable`] shows as `value`.
    fn from_readable(type_name: String, value: &Value) -> Option<Self> {
        if type_name == "string" {
            return value.as_str().map(Self::string);
        }
        let (number, count) = numbers(&type_name)?;
        let values = match value {
            Value::Array(values) if count > 1 => values.as_slice(),
            value => std::slice::from_ref(value),
        };
        let mut bytes = Vec::new();
        for value in values {
            number.write(value, &mut bytes)?;
        }
        (values.len() == count).then(|| Self::new(type_name, bytes))
    }
}

/// What the values of a readable type are made of.
#[derive(Clone, Copy)]
enum Number {
    I32,
    F32,
    F64,
}

/// A readable type's numbers, and how many it has.
fn numbers(type_name: &str) -> Option<(Number, usize)> {
    Some(match type_name {
        "int" => (Number::I32, 1),
        "v2i" => (Number::I32, 2),
        "v3i" => (Number::I32, 3),
        "box2i" => (Number::I32, 4),
        "float" => (Number::F32, 1),
        "v2f" => (Number::F32, 2),
        "v3f" => (Number::F32, 3),
        "box2f" => (Number::F32, 4),
        "chromaticities" => (Number::F32, 8),
        "m33f" => (Number::F32, 9),
        "m44f" => (Number::F32, 16),
        "double" => (Number::F64, 1),
        "v2d" => (Number::F64, 2),
        "v3d" => (Number::F64, 3),
        "m33d" => (Number::F64, 9),
        "m44d" => (Number::F64, 16),
        _ => return None,
    })
}

impl Number {
    const fn size(self) -> usize {
        match self {
            Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The JSON number for these bytes, unless they are not finite.
    fn read(self, bytes: &[u8]) -> Option<Value> {
        match self {
            Self::I32 => Some(i32::from_le_bytes(bytes.try_into().ok()?).into()),
            Self::F32 => {
                let value = f32::from_le_bytes(bytes.try_into().ok()?);
                // The shortest digits, if they come back through f64.
                let short: f64 = value.to_string().parse().ok()?;
                let exact = (short as f32).to_bits() == value.to_bits();
                let number = if exact { short } else { value.into() };
                serde_json::Number::from_f64(number).map(Value::from)
            }
            Self::F64 => {
                let value = f64::from_le_bytes(bytes.try_into().ok()?);
                serde_json::Number::from_f64(value).map(Value::from)
            }
        }
    }

    /// Appends the bytes of a JSON number.
    fn write(self, value: &Value, bytes: &mut Vec<u8>) -> Option<()> {
        match self {
            Self::I32 => {
                bytes.extend(i32::try_from(value.as_i64()?).ok()?.to_le_bytes());
            }
            Self::F32 => {
                // What is not finite is written as bytes.
                let value = Some(value.as_f64()? as f32).filter(|value| value.is_finite());
                bytes.extend(value?.to_le_bytes());
            }
            Self::F64 => bytes.extend(value.as_f64()?.to_le_bytes()),
        }
        Some(())
    }
}

/// The JSON object.
#[derive(Serialize, Deserialize)]
struct Json {
    #[serde(rename = "type")]
    type_name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    value: Option<Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hex: Option<String>,
}

impl Serialize for Attribute {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let value = self.readable();
        let hex = value
            .is_none()
            .then(|| self.bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>());
        Json { type_name: self.type_name.clone(), value, hex }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Attribute {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Json { type_name, value, hex } = Json::deserialize(deserializer)?;
        let shown = type_name.clone();
        let attribute = match (value, hex) {
            (Some(value), None) => Self::from_readable(type_name, &value),
            (None, Some(hex)) => from_hex(&hex).map(|bytes| Self::new(type_name, bytes)),
            _ => None,
        };
        attribute.ok_or_else(|| {
            de::Error::custom(format!("an attribute is no value of its type \"{shown}\""))
        })
    }
}

fn from_hex(digits: &str) -> Option<Vec<u8>> {
    let (pairs, rest) = digits.as_bytes().as_chunks::<2>();
    let byte = |&[high, low]: &[u8; 2]| {
        let digit = |digit: u8| char::from(digit).to_digit(16);
        u8::try_from(digit(high)? * 16 + digit(low)?).ok()
    };
    if rest.is_empty() { pairs.iter().map(byte).collect() } else { None }
}
