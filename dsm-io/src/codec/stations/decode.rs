//! Coded numbers into functions.

use super::kinds::{self, FirstDepths, Role};
use crate::codec::entropy::Decoder;
use crate::codec::grids::{Grids, from_zigzag};

/// The columns of a tile's functions.
#[derive(Clone, Debug, Default)]
pub(in crate::codec) struct Columns {
    pub(in crate::codec) starts: Vec<u32>,
    pub(in crate::codec) value_starts: Vec<u32>,
    pub(in crate::codec) depths: Vec<f32>,
    pub(in crate::codec) values: Vec<f32>,
}

/// Decodes a payload of so many pixels, vertices and values; why not, if it is no such
/// tile. Whether the functions are sound is left to see. O(pixels + vertices), whatever
/// the payload says.
pub(in crate::codec) fn decode(
    payload: &[u8],
    [width, height]: [u32; 2],
    channels: usize,
    [vertices, values]: [usize; 2],
) -> Result<Columns, &'static str> {
    let Some((&[depth_zeros, value_bits], coded)) = payload.split_first_chunk() else {
        return Err("it has no header");
    };
    let header = u32::from(depth_zeros) | u32::from(value_bits) << 8;
    let grids = Grids::from_header(header).ok_or("its header names no grids")?;
    let decoder = Decoder::new(coded, kinds::KINDS).ok_or("its frequencies are none")?;
    let mut tile = TileDecoder {
        decoder,
        grids,
        width: width as usize,
        pixels: width as usize * height as usize,
        channels,
        counts: Vec::new(),
        shifts: Vec::new(),
        roles: Vec::new(),
        columns: Columns::default(),
    };
    tile.take_stations(vertices)?;
    tile.take_depths()?;
    tile.take_channels(values)?;
    tile.take_values(values)?;
    if tile.decoder.is_finished() {
        Ok(tile.columns)
    } else {
        Err("its numbers are not all that it holds")
    }
}

/// A tile while its numbers come.
struct TileDecoder<'a> {
    decoder: Decoder<'a>,
    grids: Grids,
    width: usize,
    pixels: usize,
    channels: usize,
    /// The number of stations of each pixel.
    counts: Vec<u32>,
    /// By how much coarser the grid of corners is, of each pixel.
    shifts: Vec<u32>,
    /// What each vertex is, though it be the last.
    roles: Vec<Role>,
    columns: Columns,
}

impl TileDecoder<'_> {
    /// Numbers of stations, and which of them are steps.
    fn take_stations(&mut self, vertices: usize) -> Result<(), &'static str> {
        const MISMATCH: &str = "its pixels do not have as many vertices as it";
        self.counts.reserve_exact(self.pixels);
        let mut left = vertices;
        for _ in 0..self.pixels {
            let [near, above] = kinds::neighbours(&self.counts, self.width);
            let count = self.decoder.take(kinds::count(near, above));
            left = left.checked_sub(count as usize).ok_or(MISMATCH)?;
            self.counts.push(count);
        }
        self.shifts.reserve_exact(self.pixels);
        for &count in &self.counts {
            let shift = if count > 0 { self.decoder.take(kinds::SHIFT) } else { 0 };
            if shift > Grids::MOST_SHIFT {
                return Err("a grid of corners is too coarse");
            }
            self.shifts.push(shift);
        }
        self.columns.starts.reserve_exact(self.pixels + 1);
        self.columns.starts.push(0);
        self.roles.reserve_exact(vertices);
        for &count in &self.counts {
            let has_steps = count > 0 && self.decoder.take(kinds::HAS_STEPS) != 0;
            if has_steps {
                let mut before = None;
                for station in 0..count {
                    let is_last = station + 1 == count;
                    let is_step = self.decoder.take(kinds::step(before, is_last)) != 0;
                    if is_step {
                        left = left.checked_sub(1).ok_or(MISMATCH)?;
                        self.roles.extend([Role::Near, Role::Far]);
                    } else {
                        self.roles.push(Role::Corner);
                    }
                    before = Some(is_step);
                }
            } else {
                self.roles.resize(self.roles.len() + count as usize, Role::Corner);
            }
            self.columns.starts.push(self.roles.len() as u32);
        }
        if left == 0 { Ok(()) } else { Err(MISMATCH) }
    }

    fn take_depths(&mut self) -> Result<(), &'static str> {
        let most = f32::MAX.to_bits() >> self.grids.depth_zeros;
        let mut firsts = FirstDepths::new(self.width);
        self.columns.depths.reserve_exact(self.roles.len());
        let mut is_outside = false;
        for (pair, &pixel_shift) in self.columns.starts.windows(2).zip(&self.shifts) {
            let mut before: Option<(u32, bool)> = None;
            for role in &self.roles[pair[0] as usize..pair[1] as usize] {
                let is_step = *role != Role::Corner;
                if *role == Role::Far {
                    let near = self.columns.depths.last().copied();
                    self.columns.depths.extend(near);
                    continue;
                }
                let shift = if is_step { 0 } else { pixel_shift };
                let code = match before {
                    Some((code, was_step)) => {
                        let number = self.decoder.take(kinds::depth(is_step, was_step));
                        let least = (u64::from(code) + (1 << shift) - 1) >> shift;
                        (least + u64::from(number)) << shift
                    }
                    None => {
                        let change = from_zigzag(self.decoder.take(kinds::first_depth(is_step)));
                        let first = (firsts.expected() >> shift).wrapping_add(change);
                        u64::from(first) << shift
                    }
                };
                is_outside |= code > u64::from(most);
                let code = code.min(most.into()) as u32;
                if before.is_none() {
                    firsts.push(Some(code));
                }
                before = Some((code, is_step));
                self.columns.depths.push(f32::from_bits(code << self.grids.depth_zeros));
            }
            if before.is_none() {
                firsts.push(None);
            }
        }
        if is_outside { Err("a depth is none that a vertex can have") } else { Ok(()) }
    }

    /// Where the values of each pixel start, if there are several channels.
    fn take_channels(&mut self, values: usize) -> Result<(), &'static str> {
        if self.channels == 1 {
            return Ok(());
        }
        let starts = &mut self.columns.value_starts;
        starts.reserve_exact(self.pixels + 1);
        starts.push(0);
        let mut sum = 0_u64;
        for pair in self.columns.starts.windows(2) {
            let count = u64::from(pair[1] - pair[0]);
            if count > 0 {
                let is_mono = self.decoder.take(kinds::MONO) != 0;
                sum += count * if is_mono { 1 } else { self.channels as u64 };
            }
            starts.push(sum.min(u32::MAX.into()) as u32);
        }
        if sum == values as u64 {
            Ok(())
        } else {
            Err("its pixels do not have as many values as it")
        }
    }

    fn take_values(&mut self, values: usize) -> Result<(), &'static str> {
        let one = self.grids.one();
        self.columns.values.reserve_exact(values);
        let mut is_outside = false;
        let mut numbers = Vec::new();
        for (pixel, pair) in self.columns.starts.windows(2).enumerate() {
            let roles = &self.roles[pair[0] as usize..pair[1] as usize];
            if roles.is_empty() {
                continue;
            }
            let starts = &self.columns.value_starts;
            let count = match starts.get(pixel..pixel + 2) {
                Some(pair) => (pair[1] - pair[0]) as usize / roles.len(),
                None => 1,
            };
            numbers.clear();
            for channel in 0..count {
                self.columns.values.push(1.0);
                let mut value = one;
                for (index, &role) in roles.iter().enumerate().skip(1) {
                    let role = if index + 1 == roles.len() { Role::Last } else { role };
                    let told = self.decoder.take(kinds::value(role, channel, value));
                    let number = if channel == 0 {
                        if count > 1 {
                            numbers.push(told);
                        }
                        told
                    } else {
                        from_zigzag(told).wrapping_add(numbers[index - 1])
                    };
                    is_outside |= number > value;
                    let number = number.min(value);
                    value = if role == Role::Last { number } else { value - number };
                    self.columns.values.push(self.grids.value(value));
                }
            }
        }
        if is_outside { Err("a value rises or falls below 0") } else { Ok(()) }
    }
}
