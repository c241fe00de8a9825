//! Functions whose compression is known.

use dsm_core::detail::{End, SumVertex, VisibilityDifference};
use dsm_core::{Rgb, Tolerance, Transmittance, Vertex};

use crate::run;

fn mono(vertices: &[(f32, f64)]) -> Vec<SumVertex<f32>> {
    vertices.iter().map(|&(z, value)| Vertex::new(z, [value])).collect()
}

fn compressed(vertices: &[(f32, f64)], epsilon: f32, end: End<f32>) -> Vec<(f32, f32)> {
    let compressed = run::<f32>(&mono(vertices), Tolerance::new(epsilon).unwrap(), end);
    compressed.iter().map(|vertex| (vertex.z, vertex.value)).collect()
}

#[test]
fn an_opaque_blocker_never_leaks() {
    let wall = [(1.0, 1.0), (3.0, 0.9), (3.0, 0.0), (5.0, 0.0), (9.0, 0.0)];
    let blocked = compressed(&wall, 0.2, End::Known([0.0]));
    assert_eq!(blocked[1..], [(3.0, 0.9), (3.0, 0.0)], "{blocked:?}");
    assert_eq!(blocked[0], (1.0, 1.0));
}

#[test]
fn a_fall_of_twice_the_tolerance_is_a_step() {
    let sheet = [(1.0, 1.0), (2.0, 1.0), (2.0, 0.5), (3.0, 0.5), (3.0, 0.25)];
    let kept = compressed(&sheet, 0.25, End::Known([0.25]));
    assert_eq!(kept, [(2.0, 1.0), (2.0, 0.5), (3.0, 0.5), (3.0, 0.25)]);
}

#[test]
fn a_fall_at_the_first_depth_is_a_step_there() {
    let wall = [(0.0, 1.0), (0.0, 0.25)];
    assert_eq!(compressed(&wall, 0.1, End::Known([0.25])), [(0.0, 1.0), (0.0, 0.25)]);
    assert_eq!(compressed(&wall, 0.1, End::Unknown), [(0.0, 1.0), (0.0, 0.25)]);
}

#[test]
fn what_never_falls_has_no_vertices() {
    for vertices in [vec![], vec![(1.0, 1.0)], vec![(1.0, 1.0), (1.0, 1.0), (2.0, 1.0)]] {
        assert_eq!(compressed(&vertices, 0.1, End::Known([1.0])), []);
        assert_eq!(compressed(&vertices, 0.1, End::Unknown), []);
    }
    let hardly = [(1.0, 1.0), (2.0, 1.0 - 1e-9)];
    assert_eq!(compressed(&hardly, 0.1, End::Known([1.0 - 1e-9])), []);
}

#[test]
fn each_channel_ends_with_its_own_value() {
    let value = |red, green, blue| [red, green, blue];
    let vertices = [
        Vertex::new(1.0, value(1.0, 1.0, 1.0)),
        Vertex::new(1.0, value(0.0, 1.0, 0.9)),
        Vertex::new(2.0, value(0.0, 0.95, 0.8)),
        Vertex::new(4.0, value(0.0, 0.9, 0.3)),
    ];
    let tolerance = Tolerance::new(0.06).unwrap();
    let compressed = run::<Rgb>(&vertices, tolerance, End::Known(value(0.0, 0.9, 0.3)));
    assert_eq!(compressed.last(), Some(&Vertex::new(4.0, Rgb::new(0.0, 0.9, 0.3))));
    // Red steps; the others stand at the same z, green without a fall.
    assert_eq!(compressed[1], Vertex::new(1.0, Rgb::new(0.0, 1.0, 0.9)));
    assert!(compressed.iter().skip(1).all(|vertex| vertex.value.red == 0.0));
}

#[test]
fn rounding_down_is_no_reason_to_rise() {
    // The nearest f32 lies below 0.7, so below a tube that starts at V.
    let sheet = [(1.0, 1.0), (1.0, 0.7), (1.0_f32.next_up(), 0.7), (100.0, 0.7), (101.0, 0.7)];
    assert_eq!(compressed(&sheet, 0.1, End::Unknown), [(1.0, 1.0), (1.0, 0.7)]);
}

#[test]
fn a_straight_fall_of_a_million_vertices_is_one_segment() {
    let count = 1_000_000;
    let share = |index: i32| f64::from(index) / f64::from(count);
    let vertices: Vec<_> =
        (0..=count).map(|index| ((1 << 20) as f32 + index as f32, 1.0 - share(index))).collect();
    let line = [(vertices[0].0, 1.0), (vertices[vertices.len() - 1].0, 0.0)];
    assert_eq!(compressed(&vertices, 1e-4, End::Known([0.0])), line);
}

#[test]
fn a_long_curve_stays_in_its_tube() {
    let vertices: Vec<_> =
        (0..1_000_000).map(|index| (index as f32, (-5e-6 * f64::from(index)).exp())).collect();
    let curve = mono(&vertices);
    for end in [End::Known(curve[curve.len() - 1].value), End::Unknown] {
        let compressed = run::<f32>(&curve, Tolerance::new(1e-3).unwrap(), end);
        assert!(compressed.len() < 60, "{}", compressed.len());
        let stored: Vec<SumVertex<f32>> =
            compressed.iter().map(|vertex| Vertex::new(vertex.z, vertex.value.to_sum())).collect();
        assert!(VisibilityDifference::between(&curve, &stored).max() <= 1e-3);
    }
}
