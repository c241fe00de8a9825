//! Times of methods that compete for the same machine.

use std::hint::black_box;
use std::time::Instant;

/// Seconds that this thread has spent computing, where the system tells; else
/// those that have passed.
pub(crate) fn seconds(since: Instant) -> f64 {
    // The first number: nanoseconds on a processor (Linux).
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split(' ').next()?.parse::<f64>().ok())
        .map_or_else(|| since.elapsed().as_secs_f64(), |nanoseconds| nanoseconds * 1e-9)
}

/// Nanoseconds that a call of each method takes, by the median of some rounds.
/// In each round every method works for `at_least` seconds, one after the
/// other on one thread, so that what else runs on the machine meets all alike.
/// A method makes as many calls as it answers.
pub(super) fn interleaved(
    rounds: usize,
    at_least: f64,
    mut methods: Vec<Box<dyn FnMut() -> Pass + '_>>,
) -> Vec<f64> {
    let start = Instant::now();
    let mut times = vec![Vec::new(); methods.len()];
    // One more round, which fills caches and does not count.
    for round in 0..=rounds {
        for (index, method) in methods.iter_mut().enumerate() {
            let (before, mut calls) = (seconds(start), 0);
            let spent = loop {
                let pass = method();
                black_box(pass.sum);
                calls += pass.calls;
                let spent = seconds(start) - before;
                if spent >= at_least {
                    break spent;
                }
            };
            if round > 0 {
                times[index].push(spent * 1e9 / calls as f64);
            }
        }
    }
    let median = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    };
    times.into_iter().map(median).collect()
}

/// What a method did before it was asked for the time.
pub(super) struct Pass {
    pub(super) calls: usize,
    /// Of all answers, so that they are computed.
    pub(super) sum: f64,
}

/// Calls `method` for a stretch of `all` that begins where the last ended.
pub(super) fn pass<R: Copy>(
    all: &[R],
    next: &mut usize,
    length: usize,
    mut method: impl FnMut(usize, R) -> f32,
) -> Pass {
    let first = if *next >= all.len() { 0 } else { *next };
    let last = (first + length).min(all.len());
    *next = last;
    let sum = (first..last).map(|index| f64::from(method(index, all[index]))).sum();
    Pass { calls: last - first, sum }
}
