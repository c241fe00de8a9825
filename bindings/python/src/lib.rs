//! The extension module `deepshadow._deepshadow`: the front door in Python.
//!
//! Everything here translates: arguments into the front door's types, answers into numpy
//! arrays, errors into exceptions. Work runs without the interpreter's lock.

mod arrays;
mod attributes;
mod bake;
mod bake_settings;
mod camera;
mod columns;
mod convert_options;
mod deep_exr;
mod deep_image;
mod error;
mod files;
mod level;
mod light;
mod map;
mod options;
mod points;
mod progress;
mod query;
mod scene;
mod shadow;
mod source;
mod threads;
mod tile_cache;
mod values;
mod view;

/// The extension module of the package `deepshadow`.
#[pyo3::pymodule]
mod _deepshadow {
    #[pymodule_export]
    use super::bake::bake;
    #[pymodule_export]
    use super::deep_exr::{from_deep, read_deep_exr, write_deep_exr};
    #[pymodule_export]
    use super::deep_image::DeepImage;
    #[pymodule_export]
    use super::files::{convert, diff, merge, mip, verify};
    #[pymodule_export]
    use super::level::Level;
    #[pymodule_export]
    use super::light::Light;
    #[pymodule_export]
    use super::map::{Map, open};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::shadow::Shadow;
    #[pymodule_export]
    use super::tile_cache::TileCache;
    #[pymodule_export]
    use super::view::View;

    /// The names of the kinds of map.
    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::PyModuleMethods;

        let kinds: Vec<_> = deepshadow::Kind::ALL.iter().map(|kind| kind.name()).collect();
        module.add("KINDS", pyo3::types::PyTuple::new(module.py(), kinds)?)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
