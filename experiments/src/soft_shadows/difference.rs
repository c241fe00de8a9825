//! How far shadow factors are from others.

/// Of the absolute differences of all points: the paper's two numbers, and the
/// mean with its sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The mean.
    pub mean: f64,
    /// The standard deviation.
    pub deviation: f64,
    /// The mean of the differences: above 0 where too light.
    pub signed: f64,
}

impl Difference {
    /// Of `ours` from `reference`, both of one length.
    #[must_use]
    pub fn new(ours: &[f32], reference: &[f32]) -> Self {
        let differences = || ours.iter().zip(reference).map(|(&a, &b)| f64::from(a) - f64::from(b));
        let count = ours.len().max(1) as f64;
        let mean = differences().map(f64::abs).sum::<f64>() / count;
        let squares = differences().map(|d| d * d).sum::<f64>() / count;
        let signed = differences().sum::<f64>() / count;
        Self { mean, deviation: (squares - mean * mean).max(0.0).sqrt(), signed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_those_of_a_sum_by_hand() {
        let found = Difference::new(&[0.5, 0.25, 1.0, 0.0], &[0.25, 0.5, 0.5, 0.0]);
        // 0.25, −0.25, 0.5, 0.
        assert_eq!((found.mean, found.signed), (0.25, 0.125));
        assert!((found.deviation - 0.03125_f64.sqrt()).abs() < 1e-12);
    }
}
