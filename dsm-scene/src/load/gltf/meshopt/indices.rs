//! Triangles by the edges and vertices they share with those before, and sequences of
//! indices by their differences.

/// The bytes of a stream, front to back.
struct Stream<'a>(&'a [u8]);

impl Stream<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(byte)
    }

    /// A number in groups of seven bits, the lowest first.
    fn number(&mut self) -> Option<u32> {
        let mut value = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            value |= u32::from(byte & 127) << shift;
            if byte < 128 {
                return Some(value);
            }
        }
        Some(value)
    }

    /// An index as its difference from another.
    fn index(&mut self, last: u32) -> Option<u32> {
        Some(last.wrapping_add(unzigzag(self.number()?)))
    }
}

fn unzigzag(value: u32) -> u32 {
    (value >> 1) ^ (value & 1).wrapping_neg()
}

/// The last 16 things.
struct Fifo<T> {
    items: [T; 16],
    next: usize,
}

impl<T: Copy> Fifo<T> {
    fn new(item: T) -> Self {
        Self { items: [item; 16], next: 0 }
    }

    fn push(&mut self, item: T) {
        self.items[self.next] = item;
        self.next = (self.next + 1) % 16;
    }

    /// The item before the last `back`.
    fn get(&self, back: u8) -> T {
        self.items[(self.next + 31 - usize::from(back)) % 16]
    }
}

/// The indices of triangles, or `None` if the bytes are not packed in this way.
pub(super) fn triangles(packed: &[u8], count: usize) -> Option<Vec<u32>> {
    let (&header, packed) = packed.split_first()?;
    // Codes for the vertices just after and before the last are newer.
    let beyond = match header {
        0xe0 => 15,
        0xe1 => 13,
        _ => return None,
    };
    if !count.is_multiple_of(3) {
        return None;
    }
    let (codes, packed) = packed.split_at_checked(count / 3)?;
    let (data, table) = packed.split_last_chunk::<16>()?;
    let mut data = Stream(data);
    let mut vertices = Fifo::new(u32::MAX);
    let mut edges = Fifo::new([u32::MAX; 2]);
    let (mut next, mut last) = (0_u32, 0_u32);
    let mut out = Vec::with_capacity(count);
    for &code in codes {
        let mut take_next = || {
            next = next.wrapping_add(1);
            next.wrapping_sub(1)
        };
        let triangle = if code < 0xf0 {
            let ([a, b], which) = (edges.get(code >> 4), code & 15);
            let c = match which {
                0 => take_next(),
                _ if which < beyond => vertices.get(which),
                13 => last.wrapping_sub(1),
                14 => last.wrapping_add(1),
                _ => data.index(last)?,
            };
            if which >= beyond {
                last = c;
            }
            if which == 0 || which >= beyond {
                vertices.push(c);
            }
            edges.push([c, b]);
            edges.push([a, c]);
            [a, b, c]
        } else {
            let (first, rest) = match code {
                0xfe => (0, data.byte()?),
                0xff => (15, data.byte()?),
                _ => (0, table[usize::from(code & 15)]),
            };
            if code >= 0xfe && rest == 0 {
                next = 0;
            }
            let whiches = [first, rest >> 4, rest & 15];
            let mut triangle = [0; 3];
            for (corner, which) in triangle.iter_mut().zip(whiches) {
                *corner = match which {
                    0 => {
                        next = next.wrapping_add(1);
                        next.wrapping_sub(1)
                    }
                    15 => 0,
                    _ => vertices.get(which - 1),
                };
            }
            for (corner, which) in triangle.iter_mut().zip(whiches) {
                if which == 15 {
                    last = data.index(last)?;
                    *corner = last;
                }
            }
            for (corner, which) in triangle.into_iter().zip(whiches) {
                if which == 0 || which == 15 {
                    vertices.push(corner);
                }
            }
            let [a, b, c] = triangle;
            for edge in [[b, a], [c, b], [a, c]] {
                edges.push(edge);
            }
            triangle
        };
        out.extend(triangle);
    }
    data.0.is_empty().then_some(out)
}

/// A sequence of indices, or `None` if the bytes are not packed in this way.
pub(super) fn sequence(packed: &[u8], count: usize) -> Option<Vec<u32>> {
    let (&header, packed) = packed.split_first()?;
    if header & 0xf0 != 0xd0 || header & 15 > 1 {
        return None;
    }
    let (data, _) = packed.split_last_chunk::<4>()?;
    let mut data = Stream(data);
    let mut last = [0_u32; 2];
    let mut out = Vec::with_capacity(count.min(packed.len()));
    for _ in 0..count {
        let value = data.number()?;
        let last = &mut last[(value & 1) as usize];
        *last = last.wrapping_add(unzigzag(value >> 1));
        out.push(*last);
    }
    data.0.is_empty().then_some(out)
}
