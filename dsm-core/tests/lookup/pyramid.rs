//! Lookups over levels against a naive oracle in pixels of level 0: every
//! pixel of a level is visited and weighted by its offset, by the definition
//! of the footprint, and by the area of the map that it covers.

use dsm_core::detail::Pyramid;
use dsm_core::{Error, LevelChoice};

use super::*;

/// The pixels of a level, and its width.
type Pixels<T> = (u32, Vec<Vec<Vertex<T>>>);

fn sizes([width, height]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    std::iter::successors(Some([width, height]), |&size| {
        (size != [1, 1]).then(|| size.map(|side| side.div_ceil(2)))
    })
}

/// A pyramid of 1 to 4 levels that have nothing to do with each other, and
/// what to ask of it.
#[derive(Clone, Debug)]
struct PyramidCase<T> {
    levels: Vec<Pixels<T>>,
    queries: Vec<(Receiver, Footprint, LevelChoice)>,
}

fn pyramid_case<T: Transmittance>() -> impl Strategy<Value = PyramidCase<T>> {
    (1_u32..14, 1_u32..14, 1_usize..5).prop_flat_map(|(width, height, count)| {
        let levels: Vec<_> = sizes([width, height])
            .take(count)
            .map(|[width, height]| {
                let pixels = prop::collection::vec(free_pixel(), (width * height) as usize);
                (Just(width), pixels)
            })
            .collect();
        let query = (receiver(width, height), wide_footprint(), choice());
        (levels, prop::collection::vec(query, 8))
            .prop_map(|(levels, queries)| PyramidCase { levels, queries })
    })
}

/// Filters and ellipses up to 40 pixels wide, on the powers of two and
/// between.
fn wide_footprint() -> impl Strategy<Value = Footprint> {
    let isotropic = (0_usize..3, prop_oneof![1.0_f32..40.0, (1..6).prop_map(|k| 2.0_f32.powi(k))])
        .prop_map(|(shape, width)| {
            let width = width.max(SHAPES[shape].minimum_width());
            Footprint::Isotropic(Filter::new(SHAPES[shape], width).unwrap())
        });
    let elliptical = (0_usize..3, 1.0_f32..8.0, 1.0_f32..40.0, 0.0_f32..6.3).prop_map(
        |(shape, minor, aspect, angle)| {
            let (sin, cos) = angle.sin_cos();
            let major = minor * aspect;
            let axes = [[major * cos, major * sin], [-minor * sin, minor * cos]];
            Footprint::Elliptical { shape: SHAPES[shape], axes }
        },
    );
    prop_oneof![1 => Just(Footprint::Point), 4 => isotropic, 4 => elliptical]
}

fn choice() -> impl Strategy<Value = LevelChoice> {
    let whole = (-1_i8..6).prop_map(|level| LevelChoice::Fixed(f64::from(level)));
    prop_oneof![whole, (0.0..4.0).prop_map(LevelChoice::Fixed), Just(LevelChoice::Auto)]
}

fn build_pyramid<T: Transmittance>(levels: &[Pixels<T>]) -> Pyramid<DeepMap<T>> {
    Pyramid::new(levels.iter().map(|(width, pixels)| build(*width, pixels)).collect()).unwrap()
}

/// Half the major and half the minor axis of an ellipse: a b is the
/// determinant, and a² + b² the sum of the squares of all parts.
fn naive_axes(axes: [[f32; 2]; 2]) -> (f64, f64) {
    let [a, b] = axes.map(|axis| axis.map(f64::from));
    let product = (a[0] * b[1] - a[1] * b[0]).abs();
    let squares = a[0] * a[0] + a[1] * a[1] + b[0] * b[0] + b[1] * b[1];
    let (sum, difference) = ((squares + 2.0 * product).sqrt(), (squares - 2.0 * product).sqrt());
    ((sum + difference) / 2.0, (sum - difference) / 2.0)
}

/// The level that a footprint asks for, if there is no end of levels.
fn naive_level(footprint: &Footprint) -> f64 {
    match *footprint {
        Footprint::Point => 0.0,
        Footprint::Isotropic(filter) => (f64::from(filter.width()) / 2.0).log2().max(0.0),
        Footprint::Elliptical { axes, .. } => {
            let (major, minor) = naive_axes(axes);
            minor.max(major / 16.0).log2().max(0.0)
        }
    }
}

/// The footprint in pixels of level 0 that a level of pixels `side` wide has;
/// `None` if an ellipse is widened, which the oracle has no words for.
fn naive_footprint(footprint: &Footprint, side: f32) -> Option<Footprint> {
    match *footprint {
        Footprint::Point => Some(Footprint::Point),
        Footprint::Isotropic(filter) => {
            let width = filter.width().max(filter.shape().minimum_width() * side);
            Some(Footprint::Isotropic(Filter::new(filter.shape(), width).unwrap()))
        }
        Footprint::Elliptical { shape, axes } => {
            let least = f64::from(shape.minimum_width() * side) / 2.0;
            (naive_axes(axes).1 > least * 1.000_001).then_some(*footprint)
        }
    }
}

fn naive_level_lookup<T: Transmittance>(
    levels: &[Pixels<T>],
    level: usize,
    receiver: &Receiver,
    footprint: &Footprint,
    channel: usize,
) -> Option<f64> {
    let (width, pixels) = &levels[level];
    let side = f64::from(1_u32 << level);
    let map = [levels[0].0, levels[0].1.len() as u32 / levels[0].0].map(f64::from);
    let footprint = naive_footprint(footprint, side as f32)?;
    let centre = receiver.position.map(f64::from);
    let (mut sum, mut total, mut own) = (0.0, 0.0, 0.0);
    for (index, vertices) in pixels.iter().enumerate() {
        let corner = [index % *width as usize, index / *width as usize].map(|i| i as f64 * side);
        let [dx, dy] = [0, 1].map(|axis| corner[axis] + side / 2.0 - centre[axis]);
        let covered: f64 =
            [0, 1].map(|axis| (corner[axis] + side).min(map[axis]) - corner[axis]).iter().product();
        let depth = f64::from(receiver.depth) - f64::from(receiver.bias)
            + f64::from(receiver.depth_gradient[0]) * dx
            + f64::from(receiver.depth_gradient[1]) * dy;
        let depth = depth as f32;
        let value =
            if depth > 0.0 { naive_value(vertices, f64::from(depth), channel) } else { 1.0 };
        if (0..2).all(|a| corner[a] <= centre[a] && centre[a] < corner[a] + side) {
            own = value;
        }
        let weight = match footprint {
            Footprint::Point => 0.0,
            _ => covered * naive_weight(&footprint, dx, dy),
        };
        total += weight;
        sum += weight * value;
    }
    Some(if total > 0.0 { sum / total } else { own })
}

fn naive_pyramid_lookup<T: Transmittance>(
    levels: &[Pixels<T>],
    (receiver, footprint, choice): &(Receiver, Footprint, LevelChoice),
    channel: usize,
) -> Option<f64> {
    let level = match *choice {
        LevelChoice::Fixed(level) => level,
        LevelChoice::Auto => naive_level(footprint),
    };
    let level = level.clamp(0.0, levels.len() as f64 - 1.0);
    let answer =
        |level: f64| naive_level_lookup(levels, level as usize, receiver, footprint, channel);
    let (finer, coarser) = (answer(level.floor())?, answer(level.ceil())?);
    Some(finer + (coarser - finer) * level.fract())
}

fn levels_equal_the_oracle<T: Transmittance>(case: &PyramidCase<T>) -> Result<(), TestCaseError> {
    let pyramid = build_pyramid(&case.levels);
    for query in &case.queries {
        let (receiver, footprint, choice) = query;
        let Ok(found) = pyramid.lookup(receiver, footprint, *choice);
        for channel in 0..T::CHANNELS {
            let Some(oracle) = naive_pyramid_lookup(&case.levels, query, channel) else { continue };
            let found = f64::from(found.channel(channel));
            prop_assert!((found - oracle).abs() <= 2e-6, "{query:?}: {found} is not {oracle}");
        }
    }
    Ok(())
}

/// A receiver without a gradient, so that all pixels are asked at one depth.
fn facing(receiver: &Receiver) -> Receiver {
    Receiver { depth_gradient: [0.0; 2], ..*receiver }
}

proptest! {
    #![proptest_config(support::config(2053))]

    #[test]
    fn mono_levels_equal_the_oracle(case in pyramid_case::<f32>()) {
        levels_equal_the_oracle(&case)?;
    }

    #[test]
    fn rgb_levels_equal_the_oracle(case in pyramid_case::<Rgb>()) {
        levels_equal_the_oracle(&case)?;
    }

    #[test]
    fn a_constant_map_is_itself_in_every_level(
        case in pyramid_case::<f32>(),
        function in free_pixel::<f32>(),
    ) {
        let fill = |(width, pixels): &Pixels<f32>| (*width, vec![function.clone(); pixels.len()]);
        let levels: Vec<_> = case.levels.iter().map(fill).collect();
        let pyramid = build_pyramid(&levels);
        for (receiver, footprint, choice) in &case.queries {
            let receiver = facing(receiver);
            let Ok(own) = filtered_lookup(&pyramid.levels()[0], &receiver, &Footprint::Point);
            prop_assert_eq!(pyramid.lookup(&receiver, footprint, *choice), Ok(own));
        }
    }

    #[test]
    fn light_does_not_grow_with_depth(case in pyramid_case::<f32>()) {
        let pyramid = build_pyramid(&case.levels);
        for (receiver, footprint, choice) in &case.queries {
            let mut last = 1.0;
            for step in 0..120_u8 {
                let receiver = Receiver { depth: f32::from(step) / 16.0, ..facing(receiver) };
                let Ok(light) = pyramid.lookup(&receiver, footprint, *choice);
                prop_assert!((0.0..=last).contains(&light), "{light} after {last}, {receiver:?}");
                last = light;
            }
        }
    }

    #[test]
    fn levels_are_interpolated_without_a_jump(case in pyramid_case::<f32>()) {
        let pyramid = build_pyramid(&case.levels);
        for (receiver, footprint, _) in &case.queries {
            let mut last: Option<f32> = None;
            for step in 0..=64_u8 {
                let choice = LevelChoice::Fixed(f64::from(step) / 16.0);
                let Ok(light) = pyramid.lookup(receiver, footprint, choice);
                let change = last.map_or(0.0, |last| (light - last).abs());
                // No two values differ by more than 1.
                prop_assert!(change <= 1.000_001 / 16.0, "{change} at {choice:?}");
                last = Some(light);
            }
        }
    }

    /// A tent has no weight at its rim, so nothing jumps as it grows.
    #[test]
    fn a_growing_tent_crosses_levels_without_a_jump(case in pyramid_case::<f32>()) {
        let pyramid = build_pyramid(&case.levels);
        let light = |receiver, width| {
            let footprint = Footprint::Isotropic(Filter::new(FilterShape::Tent, width).unwrap());
            let Ok(light) = pyramid.lookup(receiver, &footprint, LevelChoice::Auto);
            light
        };
        for (receiver, ..) in &case.queries {
            for level in 1..6 {
                let width = 2.0_f32.powi(level + 1);
                let around = [0.999_99, 1.0, 1.000_01].map(|by| light(receiver, width * by));
                let [below, at, above] = around;
                prop_assert!((below - at).abs() < 1e-3 && (above - at).abs() < 1e-3, "{around:?}");
            }
        }
    }

    #[test]
    fn narrow_filters_read_level_0(case in pyramid_case::<f32>()) {
        let pyramid = build_pyramid(&case.levels);
        let level_0 = &pyramid.levels()[0];
        for (receiver, footprint, _) in &case.queries {
            let narrow = match *footprint {
                Footprint::Isotropic(filter) => {
                    let width = filter.shape().minimum_width().max(1.5);
                    Footprint::Isotropic(Filter::new(filter.shape(), width).unwrap())
                }
                other => other,
            };
            let auto = match narrow {
                Footprint::Elliptical { .. } => LevelChoice::FINEST,
                _ => LevelChoice::Auto,
            };
            let Ok(expected) = filtered_lookup(level_0, receiver, &narrow);
            let Ok(found) = pyramid.lookup(receiver, &narrow, auto);
            prop_assert_eq!(found.to_bits(), expected.to_bits());
        }
    }
}

fn step_to(value: f32) -> Vec<Vertex<f32>> {
    vec![Vertex::new(1.0, 1.0), Vertex::new(1.0, value)]
}

#[test]
fn a_pixel_weighs_the_area_that_it_covers() {
    let row = |width, values: &[f32]| (width, values.iter().map(|&v| step_to(v)).collect());
    let pyramid = build_pyramid(&[row(3, &[0.0; 3]), row(2, &[0.75, 0.0])]);
    let footprint = Footprint::Isotropic(Filter::new(FilterShape::Box, 8.0).unwrap());
    let receiver = Receiver::new([1.5, 0.5], 2.0);
    assert_eq!(pyramid.lookup(&receiver, &footprint, LevelChoice::Fixed(1.0)), Ok(0.5));
}

#[test]
fn a_long_ellipse_reads_the_level_of_its_minor_axis() {
    // Level k is 1 − k/8 everywhere.
    let levels: Vec<Pixels<f32>> = sizes([64, 64])
        .zip(0_u8..)
        .map(|([width, height], k)| {
            (width, vec![step_to(1.0 - f32::from(k) / 8.0); (width * height) as usize])
        })
        .collect();
    let pyramid = build_pyramid(&levels);
    let level = |minor: f32, major: f32| {
        let axes = [[minor * 0.6, minor * 0.8], [-major * 0.8, major * 0.6]];
        let footprint = Footprint::Elliptical { shape: FilterShape::Gaussian, axes };
        let receiver = Receiver::new([32.3, 31.7], 2.0);
        let Ok(light) = pyramid.lookup(&receiver, &footprint, LevelChoice::Auto);
        (1.0 - light) * 8.0
    };
    for (minor, major, expected) in [
        (0.25, 0.5, 0.0),
        (1.0, 16.0, 0.0),
        (2.0, 2.0, 1.0),
        (2.0, 32.0, 1.0),
        (2.8284, 20.0, 1.5),
        // Longer than sixteen times its width.
        (0.1, 32.0, 1.0),
        (1.0, 64.0, 2.0),
        (1e9, 1e9, 6.0),
    ] {
        let found = level(minor, major);
        assert!((found - expected).abs() < 1e-3, "{minor} by {major}: {found} is not {expected}");
    }
}

#[test]
fn levels_that_do_not_halve_are_refused() {
    let pyramid = |sizes: &[(u32, u32)]| {
        let levels = sizes.iter().map(|&(width, height)| {
            build::<f32>(width, &vec![Vec::new(); (width * height) as usize])
        });
        Pyramid::new(levels.collect()).map(|pyramid| pyramid.levels().len())
    };
    assert_eq!(pyramid(&[(5, 3), (3, 2), (2, 1), (1, 1)]), Ok(4));
    assert_eq!(pyramid(&[(5, 3)]), Ok(1));
    for (sizes, refused) in [
        (&[][..], 0),
        (&[(5, 3), (2, 2)], 1),
        (&[(5, 3), (3, 1)], 1),
        (&[(5, 3), (3, 2), (3, 2)], 2),
        (&[(1, 1), (1, 1)], 1),
    ] {
        assert!(
            matches!(pyramid(sizes), Err(Error::Level { level, .. }) if level == refused),
            "{sizes:?}"
        );
    }
}

#[test]
fn outside_the_map_is_lit_in_every_level() {
    // Level 2 is one pixel of 4 × 4, of which the map covers 3 × 1.
    let row = |width| (width, vec![step_to(0.0); width as usize]);
    let pyramid = build_pyramid(&[row(3), row(2), row(1)]);
    let footprint = Footprint::Isotropic(Filter::new(FilterShape::Tent, 8.0).unwrap());
    let light = |position, depth| {
        pyramid.lookup(&Receiver::new(position, depth), &footprint, LevelChoice::Auto)
    };
    assert_eq!(light([2.9, 0.9], 2.0), Ok(0.0));
    for position in [[3.0, 0.5], [0.5, 1.0], [-0.1, 0.5], [f32::NAN, 0.5]] {
        assert_eq!(light(position, 2.0), Ok(1.0), "{position:?}");
    }
    assert_eq!(light([0.5, 0.5], f32::NAN), Ok(1.0));
}
