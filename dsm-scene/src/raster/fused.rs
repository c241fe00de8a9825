//! One rounding for a product and a sum, on every processor.

use fearless_simd::{Level, Simd, SimdBase, SimdFloat, f32x16};

/// a · b + c, rounded once.
#[inline(always)]
pub(super) fn fused<S: Simd>(a: f32x16<S>, b: f32x16<S>, c: f32x16<S>) -> f32x16<S> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if !matches!(a.simd.level(), Level::Avx2(_) | Level::Avx512(_)) {
        let fused = one_by_one(&a.to_array(), &b.to_array(), &c.to_array());
        return f32x16::load_array(a.simd, fused);
    }
    a.mul_add_precise(b, c)
}

/// The fallback for processors without fused operations: a call a lane. Kept out of
/// the kernels, which take long to compile with it.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[cold]
#[inline(never)]
fn one_by_one(a: &[f32; 16], b: &[f32; 16], c: &[f32; 16]) -> [f32; 16] {
    std::array::from_fn(|lane| a[lane].mul_add(b[lane], c[lane]))
}
