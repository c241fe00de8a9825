//! Puts deep files together byte by byte, for what no writer makes.

pub(crate) const SCAN_CHANNELS: [(&str, i32); 2] = [("A", 1), ("Z", 2)];

/// One part, uncompressed: attributes, then chunks without part numbers.
#[derive(Clone)]
pub(crate) struct Part {
    pub(crate) attributes: Vec<(&'static str, &'static str, Vec<u8>)>,
    pub(crate) chunks: Vec<Vec<u8>>,
}

pub(crate) fn window(x0: i32, y0: i32, x1: i32, y1: i32) -> Vec<u8> {
    [x0, y0, x1, y1].iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(crate) fn channel_list(channels: &[(&str, i32)], sampling: i32) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, kind) in channels {
        bytes.extend(name.bytes());
        bytes.push(0);
        for word in [*kind, 0, sampling, sampling] {
            bytes.extend(word.to_le_bytes());
        }
    }
    bytes.push(0);
    bytes
}

pub(crate) fn tiles(width: u32, height: u32, mode: u8) -> Vec<u8> {
    [&width.to_le_bytes()[..], &height.to_le_bytes(), &[mode]].concat()
}

/// Coordinates, sizes, table and samples of an uncompressed deep chunk.
/// `counts` are those of each row; every sample is `bytes`.
pub(crate) fn chunk(coordinates: &[i32], counts: &[&[u32]], sample: &[u8]) -> Vec<u8> {
    let mut table = Vec::new();
    let mut total = 0;
    for row in counts {
        let mut sum = 0_u32;
        for count in *row {
            sum += count;
            table.extend(sum.to_le_bytes());
        }
        total += sum as usize;
    }
    let samples = sample.repeat(total);
    let mut bytes: Vec<u8> = coordinates.iter().flat_map(|c| c.to_le_bytes()).collect();
    for size in [table.len(), samples.len(), samples.len()] {
        bytes.extend((size as u64).to_le_bytes());
    }
    [bytes, table, samples].concat()
}

/// The bytes of n rows' samples of A = 0.5 (half), Z = 2.0 (float), where
/// every pixel row has one sample at most: channel by channel is then sample
/// by sample.
pub(crate) fn half_then_two() -> Vec<u8> {
    [&0x3800_u16.to_le_bytes()[..], &2.0_f32.to_le_bytes()].concat()
}

/// A deep scan line image of 2 × 3 pixels, its lines from −1 to 1; the left
/// pixel of each line has one sample.
pub(crate) fn scan_part() -> Part {
    Part {
        attributes: vec![
            ("channels", "chlist", channel_list(&SCAN_CHANNELS, 1)),
            ("compression", "compression", vec![0]),
            ("dataWindow", "box2i", window(4, -1, 5, 1)),
            ("type", "string", b"deepscanline".to_vec()),
        ],
        chunks: (-1..2).map(|y| chunk(&[y], &[&[1, 0]], &half_then_two())).collect(),
    }
}

impl Part {
    pub(crate) fn with(mut self, name: &'static str, kind: &'static str, value: Vec<u8>) -> Self {
        self.attributes.retain(|attribute| attribute.0 != name);
        self.attributes.push((name, kind, value));
        self
    }

    pub(crate) fn without(mut self, name: &str) -> Self {
        self.attributes.retain(|attribute| attribute.0 != name);
        self
    }
}

/// A whole file, and where each part's offset table begins.
pub(crate) fn file(parts: &[Part]) -> (Vec<u8>, Vec<usize>) {
    let many = parts.len() > 1;
    let flags: u32 = if many { 2 | 0x800 | 0x1000 } else { 2 | 0x800 };
    let mut bytes = [&[0x76, 0x2f, 0x31, 0x01][..], &flags.to_le_bytes()].concat();
    for part in parts {
        for (name, kind, value) in &part.attributes {
            for text in [name, kind] {
                bytes.extend(text.bytes());
                bytes.push(0);
            }
            bytes.extend((value.len() as i32).to_le_bytes());
            bytes.extend(value);
        }
        bytes.push(0);
    }
    if many {
        bytes.push(0);
    }
    let tables: Vec<usize> = parts
        .iter()
        .scan(bytes.len(), |next, part| {
            let table = *next;
            *next += 8 * part.chunks.len();
            Some(table)
        })
        .collect();
    bytes.resize(bytes.len() + 8 * parts.iter().map(|part| part.chunks.len()).sum::<usize>(), 0);
    for (index, part) in parts.iter().enumerate() {
        for (number, chunk) in part.chunks.iter().enumerate() {
            let offset = bytes.len() as u64;
            let entry = tables[index] + 8 * number;
            bytes[entry..entry + 8].copy_from_slice(&offset.to_le_bytes());
            if many {
                bytes.extend((index as i32).to_le_bytes());
            }
            bytes.extend(chunk);
        }
    }
    (bytes, tables)
}
