//! What vertices become after they are unpacked.

/// Applies a filter to elements of `stride` bytes; false if it has none for them.
///
/// Octahedral normals are left packed: no normal is read.
pub(super) fn apply(filter: &str, bytes: &mut [u8], stride: usize) -> bool {
    match (filter, stride) {
        ("OCTAHEDRAL", 4 | 8) => {}
        ("QUATERNION", 8) => bytes.as_chunks_mut::<8>().0.iter_mut().for_each(quaternion),
        ("EXPONENTIAL", _) if stride.is_multiple_of(4) => {
            bytes.as_chunks_mut::<4>().0.iter_mut().for_each(exponential);
        }
        ("COLOR", 4) => {
            for pixel in bytes.as_chunks_mut::<4>().0 {
                let [y, co, cg, alpha] = *pixel;
                let parts =
                    [i32::from(y), i32::from(co.cast_signed()), i32::from(cg.cast_signed())];
                *pixel = colour(parts, u32::from(alpha), 8).map(|part| part as u8);
            }
        }
        ("COLOR", 8) => {
            for pixel in bytes.as_chunks_mut::<8>().0 {
                let part = |at: usize| u16::from_le_bytes([pixel[2 * at], pixel[2 * at + 1]]);
                let signed = |at: usize| i32::from(part(at).cast_signed());
                let parts = [i32::from(part(0)), signed(1), signed(2)];
                let parts = colour(parts, u32::from(part(3)), 16);
                for (out, part) in pixel.as_chunks_mut::<2>().0.iter_mut().zip(parts) {
                    *out = (part as u16).to_le_bytes();
                }
            }
        }
        _ => return false,
    }
    true
}

/// A float as 24 bits times a power of two.
fn exponential(bytes: &mut [u8; 4]) {
    let value = i32::from_le_bytes(*bytes);
    let (mantissa, exponent) = (value << 8 >> 8, value >> 24);
    let value = f64::from(mantissa) * libm::exp2(f64::from(exponent));
    *bytes = (value as f32).to_le_bytes();
}

/// The three smaller parts of a rotation, and which is the largest.
fn quaternion(bytes: &mut [u8; 8]) {
    let part = |at: usize| i16::from_le_bytes([bytes[2 * at], bytes[2 * at + 1]]);
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(part(3) | 3);
    let largest = usize::from(bytes[6] & 3);
    let [x, y, z] = [0, 1, 2].map(|at| f32::from(part(at)) * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    for (at, value) in (1..).zip([x, y, z, w]) {
        let at = (largest + at) % 4;
        let code = (value * 32767.0).round() as i16;
        bytes[2 * at..2 * at + 2].copy_from_slice(&code.to_le_bytes());
    }
}

/// Red, green, blue and alpha of luma, two differences, and an alpha whose highest bit
/// tells by how much all are scaled.
fn colour([y, co, cg]: [i32; 3], alpha: u32, bits: u32) -> [u32; 4] {
    let mut scale = alpha;
    for shift in [1, 2, 4, 8] {
        scale |= scale >> shift;
    }
    let largest = (1_u32 << bits) - 1;
    let alpha = (alpha << 1 & scale) | (alpha & 1);
    let factor = largest as f32 / scale as f32;
    let part = |value: i32| {
        let value = (value as f32 * factor).round();
        if value.is_nan() { 0 } else { value.clamp(0.0, largest as f32) as u32 }
    };
    [part(y + co - cg), part(y + cg), part(y - co - cg), part(alpha as i32)]
}
