//! The metadata as JSON, before anything is read of them.

use std::collections::HashSet;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error as _, MapAccess, SeqAccess, Visitor};

use crate::error::{Error, Result};

/// Refuses a text that is not JSON all through, that has an object with a key twice, or a
/// string with half a pair of surrogates: also in values that are skipped later, so that
/// no two readers see different maps. O(bytes).
///
/// # Errors
///
/// [`Error::Json`].
pub(crate) fn check_text(json: &[u8]) -> Result<()> {
    serde_json::from_slice::<Checked>(json).map(|Checked| ()).map_err(Error::Json)
}

/// Any value.
struct Checked;

impl<'de> Deserialize<'de> for Checked {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(AnyValue)
    }
}

struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = Checked;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_bool<E>(self, _: bool) -> std::result::Result<Checked, E> {
        Ok(Checked)
    }

    fn visit_i64<E>(self, _: i64) -> std::result::Result<Checked, E> {
        Ok(Checked)
    }

    fn visit_u64<E>(self, _: u64) -> std::result::Result<Checked, E> {
        Ok(Checked)
    }

    fn visit_f64<E>(self, _: f64) -> std::result::Result<Checked, E> {
        Ok(Checked)
    }

    fn visit_str<E>(self, _: &str) -> std::result::Result<Checked, E> {
        Ok(Checked)
    }

    fn visit_unit<E>(self) -> std::result::Result<Checked, E> {
        Ok(Checked)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut all: A) -> std::result::Result<Checked, A::Error> {
        while all.next_element::<Checked>()?.is_some() {}
        Ok(Checked)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut all: A) -> std::result::Result<Checked, A::Error> {
        let mut keys = HashSet::new();
        while let Some((key, Checked)) = all.next_entry::<String, Checked>()? {
            if keys.contains(&key) {
                let shown: String = key.chars().take(60).collect();
                return Err(A::Error::custom(format!("an object has the key {shown:?} twice")));
            }
            keys.insert(key);
        }
        Ok(Checked)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_skipped_is_held_to_the_rules_too() {
        let sound =
            r#"{"a": 1, "more": [{"a": 1e3, "b": null}, {"a": "\ud83d\ude00"}], "b": {"a": -2}}"#;
        check_text(sound.as_bytes()).unwrap();
        for (broken, reason) in [
            (r#"{"a": 1, "a": 1}"#, "twice"),
            (r#"{"more": [{"x": {"a": 1, "b": 2, "a": 3}}]}"#, "twice"),
            (r#"{"more": "\ud800"}"#, "escape"),
            (r#"{"\ud800": 1}"#, "escape"),
            (r#"{"a": 1} {}"#, "trailing"),
            (r#"{"a": 1e999}"#, "out of range"),
        ] {
            let Error::Json(refused) = check_text(broken.as_bytes()).unwrap_err() else {
                panic!("{broken}: not of the text");
            };
            assert!(refused.to_string().contains(reason), "{broken}: {refused}");
        }
        let deep = [r#"{"a":"#.repeat(500), "1".to_owned(), "}".repeat(500)].concat();
        assert!(check_text(deep.as_bytes()).is_err());
    }
}
