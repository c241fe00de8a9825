//! The columns of a level, and single visibility functions.

use deepshadow::files::detail::AnyDeepMap;
use deepshadow::visibility::detail::PixelLists;
use deepshadow::visibility::{DeepMap, Rgb, Transmittance, VisibilityField};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays;
use crate::error::Result;

/// The columns of a level: first vertex of each pixel, depths, values.
pub(crate) struct LevelColumns {
    offsets: Vec<u32>,
    depths: Vec<f32>,
    values: Vec<f32>,
    channels: usize,
}

impl LevelColumns {
    /// The columns of a level. Of a mono map they are moved; of an RGB map values are put
    /// side by side. O(vertices).
    pub(crate) fn new(map: AnyDeepMap) -> Self {
        match map {
            AnyDeepMap::Mono(map) => {
                let (offsets, _, depths, values) = map.into_pixels().into_columns();
                Self { offsets, depths, values, channels: 1 }
            }
            AnyDeepMap::Rgb(map) => {
                let pixels = map.into_pixels();
                let values = side_by_side(&pixels);
                let (offsets, _, depths, _) = pixels.into_columns();
                Self { offsets, depths, values, channels: 3 }
            }
        }
    }

    /// Read-only arrays that own the columns.
    pub(crate) fn arrays(self, py: Python<'_>) -> Result<[Bound<'_, PyAny>; 3]> {
        let values = if self.channels == 1 {
            arrays::column(py, self.values)
        } else {
            arrays::rows(py, self.values, self.channels)?
        };
        Ok([arrays::column(py, self.offsets), arrays::column(py, self.depths), values])
    }
}

/// Red, green and blue of every vertex.
fn side_by_side(pixels: &PixelLists<Rgb>) -> Vec<f32> {
    let view = pixels.view();
    let mut values = Vec::with_capacity(3 * view.vertex_count());
    for function in view.functions() {
        for vertex in function.vertices() {
            values.extend((0..3).map(|channel| vertex.value.channel(channel)));
        }
    }
    values
}

/// The vertices of the only pixel of `map`: rows of a depth and its value.
pub(crate) fn vertices(py: Python<'_>, map: AnyDeepMap) -> Result<Bound<'_, PyAny>> {
    let (values, channels) = match &map {
        AnyDeepMap::Mono(map) => (rows_of_first(map), 1),
        AnyDeepMap::Rgb(map) => (rows_of_first(map), 3),
    };
    arrays::rows(py, values, 1 + channels)
}

fn rows_of_first<T: Transmittance>(map: &DeepMap<T>) -> Vec<f32> {
    let vertices = map.pixel(0, 0);
    let row = |vertex: deepshadow::visibility::Vertex<T>| {
        let values = (0..T::CHANNELS).map(move |channel| vertex.value.channel(channel));
        std::iter::once(vertex.z).chain(values)
    };
    vertices.vertices().flat_map(row).collect()
}

/// V(`depth`) of every pixel of a level, row by row, with its number of channels. On the
/// threads of the current pool.
pub(crate) fn slice(map: &AnyDeepMap, depth: f32) -> (Vec<f32>, usize) {
    match map {
        AnyDeepMap::Mono(map) => (values_at(map, depth), 1),
        AnyDeepMap::Rgb(map) => (values_at(map, depth), 3),
    }
}

fn values_at<T: Transmittance>(map: &DeepMap<T>, depth: f32) -> Vec<f32> {
    let [width, height] = map.size();
    let rows = (0..height).into_par_iter().flat_map_iter(|y| {
        (0..width).flat_map(move |x| {
            let value = map.pixel(x, y).at(depth);
            (0..T::CHANNELS).map(move |channel| value.channel(channel))
        })
    });
    rows.collect()
}
