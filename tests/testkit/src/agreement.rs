//! Tolerance between the answers of two trials.

/// The tolerance between the answers for a placed scene and those for the scene as
/// it is: by default 2⁻²⁰, and that share of answers above 1, everywhere.
///
/// Rounding moves the places that `f32` depths and rasters tell apart by some 2⁻²⁴ of
/// themselves. Where answers change at once, as at an edge, that moves a few of them:
/// strays.
///
/// ```
/// use dsm_testkit::Agreement;
///
/// let agreement = Agreement::default().with_tolerance(1e-3).with_strays(0.01);
/// assert_eq!(agreement.tolerance(), 1e-3);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    tolerance: f64,
    strays: f64,
}

impl Default for Agreement {
    fn default() -> Self {
        Self { tolerance: 1.0 / f64::from(1 << 20), strays: 0.0 }
    }
}

impl Agreement {
    /// Sets the largest error of an answer that is no stray.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// Sets the share of answers, in [0, 1], that may be off by anything.
    #[must_use]
    pub fn with_strays(self, strays: f64) -> Self {
        Self { strays, ..self }
    }

    /// The largest error of an answer that is no stray.
    #[must_use]
    pub const fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The reason why columns of answers do not agree, if they don't.
    pub(crate) fn refusal(&self, wanted: &[f64], found: &[f64]) -> Option<String> {
        if wanted.len() != found.len() {
            return Some(format!("{} answers in place of {}", found.len(), wanted.len()));
        }
        let distance =
            |index: usize| (found[index] - wanted[index]).abs() / wanted[index].abs().max(1.0);
        // Whatever is NaN is off.
        let agrees = |index: &usize| distance(*index) <= self.tolerance;
        let off = wanted.len() - (0..wanted.len()).filter(agrees).count();
        if off as f64 <= self.strays * wanted.len() as f64 {
            return None;
        }
        let worst = (0..wanted.len()).max_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
        let (count, found, wanted) = (wanted.len(), found[worst], wanted[worst]);
        Some(format!(
            "{off} of {count} answers are off; the worst is number {worst}: {found} in place of \
             {wanted}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strays_are_counted_and_nan_is_one() {
        let exact = Agreement::default();
        assert_eq!(exact.refusal(&[1.0, 0.5], &[1.0, 0.5 + 1e-7]), None);
        let refusal = exact.refusal(&[1.0, 0.5], &[1.0, 0.51]).unwrap();
        assert!(refusal.starts_with("1 of 2 answers are off; the worst is number 1"), "{refusal}");
        assert!(exact.refusal(&[0.5], &[f64::NAN]).is_some());
        assert!(exact.refusal(&[0.5], &[]).is_some());
        let loose = exact.with_strays(0.5).with_tolerance(0.1);
        assert_eq!(loose.refusal(&[1.0, 0.5], &[1.0, f64::NAN]), None);
        assert!(loose.refusal(&[1.0, 0.5], &[0.85, 0.7]).is_some());
    }
}
