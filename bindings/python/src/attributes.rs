//! Attributes of headers as Python values.

use std::collections::BTreeMap;

use deepshadow::files::{Attribute, deep_exr};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyInt, PyString};
use serde_json::{Value, json};

use crate::error::{Failure, Result};
use crate::values::object;

/// Attributes as a dict: strings, numbers, lists of numbers; what is none of these as bytes.
pub(crate) fn to_dict<'a, 'py>(
    py: Python<'py>,
    attributes: impl IntoIterator<Item = (&'a str, Attribute)>,
) -> Result<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, attribute) in attributes {
        let json = serde_json::to_value(&attribute).unwrap_or_default();
        let value = match json.get("value") {
            Some(value) => object(py, value)?,
            None => PyBytes::new(py, attribute.bytes()).into_py_any(py)?,
        };
        dict.set_item(name, value)?;
    }
    Ok(dict)
}

/// Attributes of a dict: `str`, `int`, `float`, 2, 3, 9 or 16 floats, or a pair of an
/// OpenEXR type's name and a value or bytes of that type.
pub(crate) fn from_dict(given: Option<&Bound<'_, PyAny>>) -> Result<BTreeMap<String, Attribute>> {
    let mut attributes = BTreeMap::new();
    let Some(given) = given else { return Ok(attributes) };
    let dict = given.cast::<PyDict>().map_err(PyErr::from)?;
    for (name, value) in dict.iter() {
        let name: String = name.extract()?;
        let attribute = attribute(&value)?.ok_or_else(|| {
            Failure::setting(format!(
                "attribute '{name}': a str, int, float, 2, 3, 9 or 16 floats, or (type, value)"
            ))
        })?;
        attributes.insert(name, attribute);
    }
    Ok(attributes)
}

/// The same of an image's header.
pub(crate) fn for_image(name: &str, attribute: &Attribute) -> deep_exr::Attribute {
    deep_exr::Attribute::new(name, attribute.type_name(), attribute.bytes())
}

fn attribute(value: &Bound<'_, PyAny>) -> Result<Option<Attribute>> {
    if let Ok((type_name, value)) = value.extract::<(String, Bound<'_, PyAny>)>() {
        if let Ok(bytes) = value.cast::<PyBytes>() {
            return Ok(Some(Attribute::new(type_name, bytes.as_bytes())));
        }
        let Some((_, value)) = readable(&value)? else { return Ok(None) };
        return Ok(typed(&type_name, &value));
    }
    let Some((type_name, value)) = readable(value)? else { return Ok(None) };
    Ok(typed(type_name, &value))
}

fn typed(type_name: &str, value: &Value) -> Option<Attribute> {
    serde_json::from_value(json!({ "type": type_name, "value": value })).ok()
}

/// The type that suits a value, and the value.
fn readable(value: &Bound<'_, PyAny>) -> Result<Option<(&'static str, Value)>> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Some(("string", text.to_str()?.into())));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(Some(("int", value.extract::<i64>()?.into())));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(Some(("double", number.into())));
    }
    let Ok(numbers) = value.extract::<Vec<f64>>() else { return Ok(None) };
    let type_name = match numbers.len() {
        2 => "v2d",
        3 => "v3d",
        9 => "m33d",
        16 => "m44d",
        _ => return Ok(None),
    };
    Ok(Some((type_name, numbers.into())))
}
