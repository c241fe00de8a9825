//! Functions into coded numbers.

use dsm_core::Transmittance;
use dsm_core::detail::{PixelListsView, VisibilityView};

use super::kinds::{self, FirstDepths, Role};
use crate::codec::entropy::Encoder;
use crate::codec::grids::{Grids, zigzag};

/// The payload of a tile whose vertices lie on `grids`. O(vertices).
pub(in crate::codec) fn encode<T: Transmittance>(
    pixels: PixelListsView<'_, T>,
    grids: Grids,
) -> Vec<u8> {
    let mut encoder = Encoder::new(kinds::KINDS);
    let width = pixels.width() as usize;
    let functions: Vec<Stations> =
        pixels.functions().map(|function| Stations::of(function, grids)).collect();
    let mut counts = Vec::with_capacity(functions.len());
    for function in &functions {
        let [left, above] = kinds::neighbours(&counts, width);
        let count = function.stations.len() as u32;
        encoder.push(kinds::count(left, above), count);
        counts.push(count);
    }
    for function in functions.iter().filter(|function| !function.stations.is_empty()) {
        encoder.push(kinds::SHIFT, function.shift);
    }
    for function in functions.iter().filter(|function| !function.stations.is_empty()) {
        let has_steps = function.stations.iter().any(|station| station.is_step);
        encoder.push(kinds::HAS_STEPS, has_steps.into());
        if !has_steps {
            continue;
        }
        let mut before = None;
        for (index, station) in function.stations.iter().enumerate() {
            let is_last = index + 1 == function.stations.len();
            encoder.push(kinds::step(before, is_last), station.is_step.into());
            before = Some(station.is_step);
        }
    }
    let mut firsts = FirstDepths::new(width);
    for function in &functions {
        function.push_depths(&mut firsts, &mut encoder);
    }
    if T::CHANNELS > 1 {
        for function in pixels.functions().filter(|function| !function.depths().is_empty()) {
            encoder.push(kinds::MONO, (function.columns().len() == function.depths().len()).into());
        }
    }
    for (stations, function) in functions.iter().zip(pixels.functions()) {
        push_values(&stations.stations, function, grids, &mut encoder);
    }
    [&[grids.depth_zeros as u8, grids.value_bits as u8], encoder.finish().as_slice()].concat()
}

/// A corner or a step.
#[derive(Clone, Copy, Debug)]
struct Station {
    code: u32,
    is_step: bool,
}

/// Those of a pixel, and how many zeros the codes of all corners end with.
#[derive(Clone, Debug)]
struct Stations {
    stations: Vec<Station>,
    shift: u32,
}

impl Stations {
    fn of<T: Transmittance>(function: VisibilityView<'_, T>, grids: Grids) -> Self {
        let groups = function.depths().chunk_by(|near, far| near == far);
        let stations: Vec<Station> = groups
            .map(|depths| Station {
                // −0 counts as 0.
                code: (depths[0] + 0.0).to_bits() >> grids.depth_zeros,
                is_step: depths.len() > 1,
            })
            .collect();
        let corners = stations.iter().filter(|station| !station.is_step);
        let all = corners.fold(0, |all, corner| all | corner.code);
        Self { stations, shift: if all == 0 { 0 } else { all.trailing_zeros() } }
    }

    fn push_depths(&self, firsts: &mut FirstDepths, encoder: &mut Encoder) {
        let mut before: Option<Station> = None;
        for &station in &self.stations {
            let Station { code, is_step } = station;
            let shift = if is_step { 0 } else { self.shift };
            match before.replace(station) {
                Some(before) => {
                    let least = before.code.div_ceil(1 << shift);
                    encoder.push(kinds::depth(is_step, before.is_step), (code >> shift) - least);
                }
                None => {
                    let change = (code >> shift).wrapping_sub(firsts.expected() >> shift);
                    encoder.push(kinds::first_depth(is_step), zigzag(change));
                }
            }
        }
        firsts.push(self.stations.first().map(|first| first.code));
    }
}

/// The values of a pixel, channel by channel. The first is 1, and is not told; the last
/// is told as it is, others as what the value before has more. Of other channels than
/// the first it is told what the number differs from that of the first.
fn push_values<T: Transmittance>(
    stations: &[Station],
    function: VisibilityView<'_, T>,
    grids: Grids,
    encoder: &mut Encoder,
) {
    let count = function.depths().len();
    let roles = || {
        let of = |station: &Station| if station.is_step { STEP } else { CORNER };
        stations.iter().flat_map(of).enumerate().skip(1)
    };
    let mut numbers = vec![0; count];
    for (channel, values) in function.columns().chunks_exact(count.max(1)).enumerate() {
        for (index, &role) in roles() {
            let role = if index + 1 == count { Role::Last } else { role };
            let [before, code] =
                [values[index - 1], values[index]].map(|value| grids.value_code(value));
            let number = if role == Role::Last { code } else { before - code };
            let told = if channel == 0 {
                numbers[index] = number;
                number
            } else {
                zigzag(number.wrapping_sub(numbers[index]))
            };
            encoder.push(kinds::value(role, channel, before), told);
        }
    }
}

const CORNER: &[Role] = &[Role::Corner];
const STEP: &[Role] = &[Role::Near, Role::Far];
