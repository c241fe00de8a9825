//! Vertices: bytes of the same place in each element together, as differences.

/// Elements come in groups of these.
const GROUP: usize = 16;

/// The elements, or `None` if the bytes are not packed in this way.
pub(super) fn decode(packed: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    if stride == 0 || stride > 256 || !stride.is_multiple_of(4) {
        return None;
    }
    let (&header, packed) = packed.split_first()?;
    let version = match header {
        0xa0 => 0,
        0xa1 => 1,
        _ => return None,
    };
    // The tail: padding, the element before the first, how differences are made.
    let channels = if version == 0 { 0 } else { stride / 4 };
    let least = if version == 0 { 32 } else { 24 };
    let tail = (stride + channels).max(least);
    let (mut data, tail) = packed.split_at(packed.len().checked_sub(tail)?);
    let (first, channels) = tail[tail.len() - stride - channels..].split_at(stride);
    let mut last = first.to_vec();
    let mut out = vec![0; count * stride];
    let block = ((8192 / stride) & !(GROUP - 1)).min(256);
    for elements in out.chunks_mut(block * stride) {
        data = decode_block(data, elements, &mut last, channels, version)?;
    }
    data.is_empty().then_some(out)
}

/// Decodes one block and returns the data after it.
fn decode_block<'a>(
    data: &'a [u8],
    out: &mut [u8],
    last: &mut [u8],
    channels: &[u8],
    version: u8,
) -> Option<&'a [u8]> {
    let stride = last.len();
    let count = out.len() / stride;
    let (control, mut data) = data.split_at_checked(channels.len())?;
    let mut differences = [[0; 256]; 4];
    for word in 0..stride / 4 {
        for (byte, differences) in differences.iter_mut().enumerate() {
            let differences = &mut differences[..count.next_multiple_of(GROUP)];
            let how = control.get(word).map_or(0, |control| control >> (2 * byte) & 3);
            match (version, how) {
                (0, _) => data = decode_bytes(data, differences, [0, 2, 4, 8])?,
                (_, 0) => data = decode_bytes(data, differences, [0, 1, 2, 4])?,
                (_, 1) => data = decode_bytes(data, differences, [1, 2, 4, 8])?,
                (_, 2) => differences.fill(0),
                _ => {
                    let (raw, rest) = data.split_at_checked(count)?;
                    differences[..count].copy_from_slice(raw);
                    data = rest;
                }
            }
        }
        let channel = channels.get(word).copied().unwrap_or(0);
        let last = &mut last[4 * word..4 * word + 4];
        for element in 0..count {
            let found = differences.map(|differences| differences[element]);
            let before = [last[0], last[1], last[2], last[3]];
            let value = match channel & 3 {
                0 => std::array::from_fn(|at| before[at].wrapping_add(unzigzag8(found[at]))),
                1 => add16(before, found),
                2 => {
                    let turn = u32::from(channel >> 4);
                    let difference = u32::from_le_bytes(found).rotate_right(turn);
                    (u32::from_le_bytes(before) ^ difference).to_le_bytes()
                }
                _ => return None,
            };
            last.copy_from_slice(&value);
            out[element * stride + 4 * word..][..4].copy_from_slice(&value);
        }
    }
    Some(data)
}

fn unzigzag8(value: u8) -> u8 {
    (value >> 1) ^ (value & 1).wrapping_neg()
}

fn add16(before: [u8; 4], found: [u8; 4]) -> [u8; 4] {
    let part = |at: usize| {
        let difference = u16::from_le_bytes([found[at], found[at + 1]]);
        let difference = (difference >> 1) ^ (difference & 1).wrapping_neg();
        u16::from_le_bytes([before[at], before[at + 1]]).wrapping_add(difference).to_le_bytes()
    };
    let ([a, b], [c, d]) = (part(0), part(2));
    [a, b, c, d]
}

/// Groups of bytes, each of one of four numbers of `bits`; a byte that has none but
/// ones in so many bits follows whole.
fn decode_bytes<'a>(data: &'a [u8], out: &mut [u8], bits: [u8; 4]) -> Option<&'a [u8]> {
    let groups = out.len() / GROUP;
    let (header, mut data) = data.split_at_checked(groups.div_ceil(4))?;
    for (group, out) in out.as_chunks_mut::<GROUP>().0.iter_mut().enumerate() {
        let bits = usize::from(bits[usize::from(header[group / 4] >> (2 * (group % 4)) & 3)]);
        if bits == 0 {
            out.fill(0);
            continue;
        }
        let (packed, rest) = data.split_at_checked(2 * bits)?;
        data = rest;
        if bits == 8 {
            out.copy_from_slice(packed);
            continue;
        }
        let ones = (1_u8 << bits) - 1;
        for (at, out) in out.iter_mut().enumerate() {
            // From the highest bits on, but single bits from the lowest.
            let place = at * bits % 8;
            let shift = if bits == 1 { place } else { 8 - bits - place };
            *out = packed[at * bits / 8] >> shift & ones;
            if *out == ones {
                let (&whole, rest) = data.split_first()?;
                *out = whole;
                data = rest;
            }
        }
    }
    Some(data)
}
