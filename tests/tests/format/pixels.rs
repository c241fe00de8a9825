//! Pixels to write: any that the invariant allows.

use dsm_core::detail::PixelLists;
use dsm_core::{PixelListsBuilder, Transmittance, Vertex};
use proptest::collection::{btree_set, vec};
use proptest::prelude::*;

/// Bit patterns of the values of one channel: non-increasing, first 1.
fn falling(count: usize) -> impl Strategy<Value = Vec<f32>> {
    // Quarters tie; other bit patterns don't.
    let value = prop_oneof![
        (0_u8..=4).prop_map(|quarters| f32::from(quarters) * 0.25),
        (0_u32..=0x3f80_0000).prop_map(f32::from_bits),
    ];
    vec(value, count).prop_map(|mut values| {
        values.sort_by(|a, b| b.total_cmp(a));
        if let Some(first) = values.first_mut() {
            *first = 1.0;
        }
        values
    })
}

/// Depths, sorted, some of them twice.
fn depths() -> impl Strategy<Value = Vec<f32>> {
    let z = prop_oneof![
        (0_u16..8).prop_map(|halves| (f32::from(halves) * 0.5).to_bits()),
        0..f32::INFINITY.to_bits(),
    ];
    (btree_set(z, 0..5), vec(any::<bool>(), 5)).prop_map(|(bits, twice)| {
        let steps = bits.into_iter().zip(twice);
        let mut z: Vec<f32> = steps
            .flat_map(|(bits, twice)| vec![f32::from_bits(bits); 1 + usize::from(twice)])
            .collect();
        // Zero has two encodings.
        if z.first() == Some(&0.0) && z.len() % 2 == 1 {
            z[0] = -0.0;
        }
        z
    })
}

fn pixel<T: Transmittance>() -> impl Strategy<Value = Vec<Vertex<T>>> {
    depths().prop_flat_map(|z| {
        let count = z.len();
        (Just(z), vec(falling(count), T::CHANNELS), any::<bool>()).prop_map(
            |(z, channels, mono)| {
                let value = |i: usize| T::from_channels(|c| channels[if mono { 0 } else { c }][i]);
                (0..z.len()).map(|i| Vertex::new(z[i], value(i))).collect()
            },
        )
    })
}

/// So many pixels, many of them empty.
pub(crate) fn pixel_lists_of<T: Transmittance>(
    width: u32,
    height: u32,
) -> impl Strategy<Value = PixelLists<T>> {
    let pixel = prop_oneof![1 => Just(Vec::new()), 2 => pixel::<T>()];
    vec(pixel, (width * height) as usize).prop_map(move |pixels| build(width, height, pixels))
}

/// These pixels, row by row.
pub(crate) fn build<T: Transmittance>(
    width: u32,
    height: u32,
    pixels: impl IntoIterator<Item = Vec<Vertex<T>>>,
) -> PixelLists<T> {
    let mut lists = PixelListsBuilder::new(width, height);
    for pixel in pixels {
        pixel.into_iter().for_each(|vertex| lists.push(vertex));
        lists.finish_pixel().unwrap();
    }
    lists.finish().unwrap()
}
