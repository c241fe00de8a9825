//! Queries repeated in every trial.

use crate::agreement::Agreement;
use crate::disagreement::Disagreement;
use crate::trial::Trial;

/// Checks any method: `answers` builds it from the scene of a trial, which has this
/// radius before it is placed, and queries it. The numbers, which have no unit, are
/// equal bit by bit where only tiles and threads differ, and agree wherever the
/// scene stands and however large it is.
///
/// ```
/// use dsm_testkit::{Agreement, Trial, check_answers};
///
/// let agreement = Agreement::default();
/// let share = |trial: &Trial| Ok(vec![trial.placement.scale() / trial.placement.scale()]);
/// assert!(check_answers(1.0, &agreement, share).is_ok());
/// let length = |trial: &Trial| Ok(vec![trial.placement.scale()]);
/// let refused = check_answers(1.0, &agreement, length).unwrap_err();
/// assert_eq!(refused.trial.placement.scale(), 1e-4);
/// ```
///
/// # Errors
///
/// The first trial whose answers are wrong, and what is wrong with them.
pub fn check_answers(
    radius: f64,
    agreement: &Agreement,
    answers: impl Fn(&Trial) -> Result<Vec<f64>, String> + Sync,
) -> Result<(), Disagreement> {
    let ask = |trial: &Trial| {
        let found = trial.run(|| answers(trial)).and_then(|answers| answers);
        found.map_err(|reason| Disagreement::new(trial, reason))
    };
    let first = ask(&Trial::FIRST)?;
    let exact = Agreement::default().with_tolerance(0.0);
    let alike = Trial::alike().map(|trial| (trial, exact));
    let elsewhere = Trial::elsewhere(radius).map(|trial| (trial, *agreement));
    for (trial, agreement) in alike.into_iter().chain(elsewhere) {
        if let Some(reason) = agreement.refusal(&first, &ask(&trial)?) {
            return Err(Disagreement::new(&trial, reason));
        }
    }
    Ok(())
}
