//! The exponential of 16 optical depths.

use fearless_simd::{Bytes, Simd, SimdBase, SimdFloat, f32x16, i32x16};

/// exp(−x) for x ≥ 0, to about 1e-6, of the same bits on every processor.
#[inline(always)]
pub(super) fn exponential<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    let splat = |value| f32x16::splat(simd, value);
    // 2 to the power of a whole number, which are the bits of the exponent, and
    // of a rest in [−½, ½].
    let power = (x * std::f32::consts::LOG2_E).max(splat(0.0)).min(splat(126.0));
    let whole = (power + 0.5).floor();
    let rest = whole - power;
    let mut sum = splat(0.000_154_035_3);
    for factor in
        [0.001_333_355_8, 0.009_618_129, 0.055_504_11, 0.240_226_5, std::f32::consts::LN_2, 1.0]
    {
        sum = sum * rest + factor;
    }
    let bits: i32x16<S> = whole.to_int();
    let scale = (i32x16::splat(simd, 127) - bits) << 23;
    sum * scale.bitcast::<f32x16<S>>()
}
