//! Filtered lookups against a naive oracle: every pixel of the map is visited,
//! every function evaluated by linear search in f64.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use dsm_core::detail::{TransmittanceFunction, VisibilitySweep};
use dsm_core::{
    DeepMap, Filter, FilterShape, Footprint, MapInfo, PixelListsBuilder, Receiver, Rgb,
    Transmittance, Vertex, filtered_lookup,
};
use proptest::prelude::*;

mod pyramid;
#[expect(dead_code, reason = "shared with the tests of sampling")]
#[path = "../support/mod.rs"]
mod support;

const SHAPES: [FilterShape; 3] = [FilterShape::Box, FilterShape::Tent, FilterShape::Gaussian];

/// V(z) by linear search: the value after the last vertex at depth ≤ z,
/// moved towards the next one.
fn naive_value<T: Transmittance>(vertices: &[Vertex<T>], z: f64, channel: usize) -> f64 {
    let mut value = 1.0;
    for (index, vertex) in vertices.iter().enumerate() {
        if f64::from(vertex.z) > z {
            break;
        }
        value = f64::from(vertex.value.channel(channel));
        if let Some(next) = vertices.get(index + 1).filter(|next| f64::from(next.z) > z) {
            let share = (z - f64::from(vertex.z)) / (f64::from(next.z) - f64::from(vertex.z));
            value += (f64::from(next.value.channel(channel)) - value) * share;
        }
    }
    value
}

fn naive_shape(shape: FilterShape, t: f64) -> f64 {
    match shape {
        FilterShape::Box => 1.0,
        FilterShape::Tent => (1.0 - t.abs()).max(0.0),
        FilterShape::Gaussian => (-2.0 * t * t).exp(),
    }
}

/// The weight of a pixel whose centre lies (dx, dy) from the receiver, by the
/// definition of the footprint.
fn naive_weight(footprint: &Footprint, dx: f64, dy: f64) -> f64 {
    match *footprint {
        Footprint::Point => f64::from((-0.5 < dx && dx <= 0.5 && -0.5 < dy && dy <= 0.5) as u8),
        Footprint::Isotropic(filter) => {
            let half = f64::from(filter.width()) / 2.0;
            let along = |d: f64| match d {
                d if d > -half && d <= half => naive_shape(filter.shape(), d / half),
                _ => 0.0,
            };
            along(dx) * along(dy)
        }
        Footprint::Elliptical { shape, axes: [a, b] } => {
            // Cramer's rule for (dx, dy) = u a + v b.
            let [a, b] = [a, b].map(|axis| axis.map(f64::from));
            let determinant = a[0] * b[1] - a[1] * b[0];
            let u = (dx * b[1] - dy * b[0]) / determinant;
            let v = (a[0] * dy - a[1] * dx) / determinant;
            match u.hypot(v) {
                radius if radius <= 1.0 => naive_shape(shape, radius),
                _ => 0.0,
            }
        }
    }
}

fn naive_lookup<T: Transmittance>(
    pixels: &[Vec<Vertex<T>>],
    width: usize,
    receiver: &Receiver,
    footprint: &Footprint,
    channel: usize,
) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (index, vertices) in pixels.iter().enumerate() {
        let dx = (index % width) as f64 + 0.5 - f64::from(receiver.position[0]);
        let dy = (index / width) as f64 + 0.5 - f64::from(receiver.position[1]);
        let weight = naive_weight(footprint, dx, dy);
        let depth = f64::from(receiver.depth) - f64::from(receiver.bias)
            + f64::from(receiver.depth_gradient[0]) * dx
            + f64::from(receiver.depth_gradient[1]) * dy;
        let depth = depth as f32;
        total += weight;
        sum += weight
            * if depth > 0.0 { naive_value(vertices, f64::from(depth), channel) } else { 1.0 };
    }
    sum / total
}

/// Pixel functions: of rays, half of them on a grid of depths and opacities,
/// or of any vertices.
fn pixel<T: Transmittance>() -> impl Strategy<Value = Vec<Vertex<T>>> {
    let ray = support::ray_hits::<T>(4).prop_map(|hits| {
        let ray = TransmittanceFunction::new(&hits, 0.05);
        let mut sweep = VisibilitySweep::default();
        let function = sweep.over(&[(1.0, &ray)]).visibility_function();
        function.view().vertices().collect()
    });
    prop_oneof![3 => ray, 1 => free_pixel()]
}

/// Vertices on whole depths and between, with drops by quarters.
fn free_pixel<T: Transmittance>() -> impl Strategy<Value = Vec<Vertex<T>>> {
    let vertex = (any::<bool>(), 1_u8..6, 0.1_f32..6.0, prop::array::uniform3(0_u8..5));
    prop::collection::vec(vertex, 0..6).prop_map(|drafts| {
        let mut depths: Vec<f32> = drafts
            .iter()
            .map(|&(integer, grid, free, _)| if integer { f32::from(grid) } else { free })
            .collect();
        depths.sort_by(f32::total_cmp);
        let mut left = [1.0_f32; 3];
        let mut vertices: Vec<Vertex<T>> = Vec::new();
        for (z, (.., drops)) in depths.into_iter().zip(drafts) {
            if vertices.len() > 1 && vertices[vertices.len() - 2].z == z {
                continue;
            }
            if !vertices.is_empty() {
                for (left, drop) in left.iter_mut().zip(drops) {
                    *left *= 1.0 - f32::from(drop) * 0.25;
                }
            }
            vertices.push(Vertex::new(z, T::from_channels(|channel| left[channel])));
        }
        vertices
    })
}

fn footprint() -> impl Strategy<Value = Footprint> {
    let isotropic = (0_usize..3, 0.0_f32..9.0).prop_map(|(shape, extra)| {
        let shape = SHAPES[shape];
        Footprint::Isotropic(Filter::new(shape, shape.minimum_width() + extra).unwrap())
    });
    // Axes at least a pixel long and not parallel, so that nothing is widened
    // and some pixel centre is always inside.
    let elliptical = (0_usize..3, 1.5_f32..6.0, 1.5_f32..6.0, 0.0_f32..6.3, 0.0_f32..0.5).prop_map(
        |(shape, a, b, angle, shear)| Footprint::Elliptical {
            shape: SHAPES[shape],
            axes: [
                [a * angle.cos(), a * angle.sin()],
                [b * (-angle.sin() + shear * angle.cos()), b * (angle.cos() + shear * angle.sin())],
            ],
        },
    );
    prop_oneof![Just(Footprint::Point), isotropic, elliptical]
}

fn receiver(width: u32, height: u32) -> impl Strategy<Value = Receiver> {
    let coordinate = |size: u32| {
        prop_oneof![
            0.0..size as f32,
            (0..size).prop_map(|c| c as f32),
            (0..size).prop_map(|c| c as f32 + 0.5)
        ]
    };
    let depth = prop_oneof![0.0_f32..8.0, (1_u8..6).prop_map(f32::from)];
    let bias = prop_oneof![Just(0.0_f32), -0.5_f32..0.5];
    let gradient = prop_oneof![Just([0.0_f32; 2]), [-0.5_f32..0.5, -0.5_f32..0.5]];
    ((coordinate(width), coordinate(height)), depth, bias, gradient).prop_map(
        |((x, y), depth, bias, depth_gradient)| Receiver {
            position: [x, y],
            depth: depth.max(0.01),
            bias,
            depth_gradient,
        },
    )
}

/// A map's width and pixels, and what to ask of it.
type Case<T> = (u32, Vec<Vec<Vertex<T>>>, Vec<(Receiver, Footprint)>);

fn case<T: Transmittance>() -> impl Strategy<Value = Case<T>> {
    (1_u32..9, 1_u32..9).prop_flat_map(|(width, height)| {
        (
            Just(width),
            prop::collection::vec(pixel(), (width * height) as usize),
            prop::collection::vec((receiver(width, height), footprint()), 8),
        )
    })
}

fn build<T: Transmittance>(width: u32, pixels: &[Vec<Vertex<T>>]) -> DeepMap<T> {
    let mut builder = PixelListsBuilder::new(width, pixels.len() as u32 / width);
    for pixel in pixels {
        pixel.iter().for_each(|&vertex| builder.push(vertex));
        builder.finish_pixel().unwrap();
    }
    DeepMap::new(MapInfo::default(), builder.finish().unwrap())
}

fn equals_the_oracle<T: Transmittance>(
    width: u32,
    pixels: &[Vec<Vertex<T>>],
    queries: &[(Receiver, Footprint)],
) -> Result<(), TestCaseError> {
    let map = build(width, pixels);
    for (receiver, footprint) in queries {
        let Ok(found) = filtered_lookup(&map, receiver, footprint);
        for channel in 0..T::CHANNELS {
            let oracle = naive_lookup(pixels, width as usize, receiver, footprint, channel);
            let found = f64::from(found.channel(channel));
            prop_assert!(
                (found - oracle).abs() <= 1e-6,
                "{receiver:?} {footprint:?}: {found} is not {oracle}"
            );
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(support::config(2000))]

    #[test]
    fn mono_equals_the_oracle((width, pixels, queries) in case::<f32>()) {
        equals_the_oracle(width, &pixels, &queries)?;
    }

    #[test]
    fn rgb_equals_the_oracle((width, pixels, queries) in case::<Rgb>()) {
        equals_the_oracle(width, &pixels, &queries)?;
    }
}

fn blocked_left_of_clear() -> DeepMap<f32> {
    build(2, &[vec![Vertex::new(1.0, 1.0), Vertex::new(1.0, 0.0)], vec![]])
}

#[test]
fn what_lies_outside_is_lit() {
    let map = blocked_left_of_clear();
    let wide = Footprint::Isotropic(Filter::new(FilterShape::Box, 8.0).unwrap());
    for position in [[-0.1, 0.5], [2.0, 0.5], [0.5, 1.0], [0.5, f32::NAN], [f32::INFINITY, 0.5]] {
        assert_eq!(filtered_lookup(&map, &Receiver::new(position, 2.0), &wide), Ok(1.0));
    }
    for depth in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
        assert_eq!(filtered_lookup(&map, &Receiver::new([0.5, 0.5], depth), &wide), Ok(1.0));
    }
    assert_eq!(filtered_lookup(&map, &Receiver::new([0.5, 0.5], f32::INFINITY), &wide), Ok(0.5));
}

#[test]
fn the_border_is_normalised() {
    let map = blocked_left_of_clear();
    let wide = Footprint::Isotropic(Filter::new(FilterShape::Box, 3.0).unwrap());
    // The filter reaches columns −1 to 1; column −1 has no weight.
    assert_eq!(filtered_lookup(&map, &Receiver::new([0.5, 0.5], 2.0), &wide), Ok(0.5));
}

#[test]
fn a_bias_asks_nearer_to_the_light() {
    let map = blocked_left_of_clear();
    let receiver = Receiver { bias: 0.5, ..Receiver::new([0.5, 0.5], 1.25) };
    assert_eq!(filtered_lookup(&map, &receiver, &Footprint::Point), Ok(1.0));
}

#[test]
fn an_ellipse_thinner_than_a_pixel_still_answers() {
    let map = blocked_left_of_clear();
    for axes in [[[0.0; 2]; 2], [[1e-30, 0.0], [0.0, 1e-30]], [[0.3, 0.3], [0.3, 0.3]]] {
        let footprint = Footprint::Elliptical { shape: FilterShape::Box, axes };
        let receiver = Receiver::new([0.95, 0.05], 2.0);
        assert_eq!(filtered_lookup(&map, &receiver, &footprint), Ok(0.0), "{axes:?}");
    }
}

#[test]
fn a_circle_of_equal_axes_is_symmetric() {
    let map = blocked_left_of_clear();
    let footprint =
        Footprint::Elliptical { shape: FilterShape::Gaussian, axes: [[3.0, 0.0], [0.0, 3.0]] };
    let light = filtered_lookup(&map, &Receiver::new([1.0, 0.5], 2.0), &footprint).unwrap();
    assert!((light - 0.5).abs() < 1e-6);
}
