//! Random visibility functions with everything that is hard about them, and
//! their naive evaluation.

use dsm_core::detail::SumVertex;
use dsm_core::{Transmittance, Vertex};
use proptest::prelude::*;

/// What happens to the function on the way to the next depth.
#[derive(Clone, Debug)]
struct Move {
    /// How the next depth follows from the last.
    depth: DepthMove,
    /// What is lost linearly on the way there.
    fall: Loss,
    /// What is lost there at once; none: a single vertex.
    step: Option<Loss>,
}

#[derive(Clone, Copy, Debug)]
enum DepthMove {
    /// The next whole number.
    Grid,
    /// The next `f32`.
    Neighbour,
    /// Further by this.
    Further(f32),
    /// This many times as far.
    Times(f32),
}

/// One loss a channel; a mono function takes the first.
#[derive(Clone, Debug)]
struct Loss([ChannelLoss; 3]);

#[derive(Clone, Copy, Debug)]
enum ChannelLoss {
    Nothing,
    /// A sheet of this opacity.
    Opacity(f64),
    /// This many ε.
    Epsilons(f64),
}

/// A function before it is known how many channels it has and which ε its
/// losses are measured in.
#[derive(Clone, Debug)]
pub(crate) struct Recipe {
    start: f32,
    clear: u8,
    moves: Vec<Move>,
}

const OPACITIES: [f64; 5] = [0.0, 1.0 / (1 << 24) as f64, 0.5, 1.0 - 1.0 / (1 << 24) as f64, 1.0];

fn channel_loss() -> impl Strategy<Value = ChannelLoss> {
    prop_oneof![
        2 => Just(ChannelLoss::Nothing),
        1 => (0..OPACITIES.len()).prop_map(|index| ChannelLoss::Opacity(OPACITIES[index])),
        4 => (0.0..0.2).prop_map(ChannelLoss::Opacity),
        1 => Just(ChannelLoss::Epsilons(2.0)),
        1 => Just(ChannelLoss::Epsilons(1.0)),
        1 => (0.0..3.0).prop_map(ChannelLoss::Epsilons),
    ]
}

fn loss() -> impl Strategy<Value = Loss> {
    prop_oneof![
        channel_loss().prop_map(|loss| Loss([loss; 3])),
        [channel_loss(), channel_loss(), channel_loss()].prop_map(Loss),
    ]
}

fn moves(depth: impl Strategy<Value = DepthMove>) -> impl Strategy<Value = Vec<Move>> {
    let quiet = Just(Loss([ChannelLoss::Nothing; 3]));
    let one = (depth, prop_oneof![quiet, loss()], proptest::option::weighted(0.7, loss()))
        .prop_map(|(depth, fall, step)| Move { depth, fall, step });
    proptest::collection::vec(one, 0..40)
}

/// Half of the recipes stand on the whole numbers.
pub(crate) fn recipe() -> impl Strategy<Value = Recipe> {
    let grid = (0_u8..3, 0_u8..3, moves(Just(DepthMove::Grid)))
        .prop_map(|(start, clear, moves)| Recipe { start: f32::from(start), clear, moves });
    let anywhere = prop_oneof![
        2 => Just(DepthMove::Neighbour),
        4 => (1e-3_f32..1.0).prop_map(DepthMove::Further),
        1 => (-44.0_f32..38.0).prop_map(|power| DepthMove::Further(10_f32.powf(power))),
        1 => (1.0_f32..10.0).prop_map(DepthMove::Times),
    ];
    let start = prop_oneof![Just(0.0), Just(1.0), Just(f32::from_bits(1)), 0.0_f32..100.0];
    let free = (start, 0_u8..3, moves(anywhere)).prop_map(|(start, clear, moves)| Recipe {
        start,
        clear,
        moves,
    });
    prop_oneof![grid, free]
}

impl Recipe {
    /// The function's vertices.
    pub(crate) fn vertices<T: Transmittance>(&self, epsilon: f64) -> Vec<SumVertex<T>> {
        let mut z = self.start;
        let mut value = T::CLEAR.to_sum();
        let mut vertices = vec![Vertex::new(z, value); 1 + usize::from(self.clear > 1)];
        for next in &self.moves {
            let further = match next.depth {
                DepthMove::Grid => z + 1.0,
                DepthMove::Neighbour => z.next_up(),
                DepthMove::Further(by) => (z + by).max(z.next_up()),
                DepthMove::Times(times) => (z * times).max(z.next_up()),
            };
            if !further.is_finite() {
                break;
            }
            z = further;
            value = next.fall.apply::<T>(value, epsilon);
            vertices.push(Vertex::new(z, value));
            if let Some(step) = &next.step {
                value = step.apply::<T>(value, epsilon);
                vertices.push(Vertex::new(z, value));
            }
        }
        vertices
    }
}

impl Loss {
    fn apply<T: Transmittance>(&self, value: T::Sum, epsilon: f64) -> T::Sum {
        T::sum_from_channels(|channel| {
            let value = value.as_ref()[channel];
            match self.0[channel] {
                ChannelLoss::Nothing => value,
                ChannelLoss::Opacity(opacity) => value * (1.0 - opacity),
                ChannelLoss::Epsilons(count) => (value - count * epsilon).max(0.0),
            }
        })
    }
}

/// The limits of a function from both sides of `z`, by looking at every
/// vertex and every edge.
pub(crate) fn both_sides<S: AsRef<[f64]>>(
    vertices: &[Vertex<S>],
    channel: usize,
    z: f32,
) -> [f64; 2] {
    let value = |vertex: &Vertex<S>| vertex.value.as_ref()[channel];
    let (Some(first), Some(last)) = (vertices.first(), vertices.last()) else {
        return [1.0; 2];
    };
    let mut sides = [f64::NAN; 2];
    if z <= first.z {
        sides[0] = 1.0;
    }
    if z < first.z {
        sides[1] = 1.0;
    }
    if z > last.z {
        sides[0] = value(last);
    }
    if z >= last.z {
        sides[1] = value(last);
    }
    for edge in vertices.windows(2) {
        let (from, to) = (&edge[0], &edge[1]);
        let share = (f64::from(z) - f64::from(from.z)) / (f64::from(to.z) - f64::from(from.z));
        let on_edge = value(from) * (1.0 - share) + value(to) * share;
        if from.z < z && z <= to.z {
            sides[0] = on_edge;
        }
        if from.z <= z && z < to.z {
            sides[1] = on_edge;
        }
    }
    sides
}

/// The largest difference at any vertex of either, at both sides.
pub(crate) fn largest_difference<S: AsRef<[f64]>>(a: &[Vertex<S>], b: &[Vertex<S>]) -> f64 {
    let mut largest = 0.0_f64;
    for z in a.iter().chain(b).map(|vertex| vertex.z) {
        for channel in 0..a[0].value.as_ref().len() {
            let (a, b) = (both_sides(a, channel, z), both_sides(b, channel, z));
            for (a, b) in a.iter().zip(b) {
                assert!(!(a - b).is_nan(), "a hole at {z}");
                largest = largest.max((a - b).abs());
            }
        }
    }
    largest
}
