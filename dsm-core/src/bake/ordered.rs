//! Work in parallel whose results come in order.

use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::ScopeFifo;

/// Does `work` for 0, 1, … below `count` on the current rayon pool and hands
/// the results to `sink` in that order, one at a time, from any thread. At most
/// `window` pieces are begun and not yet handed over. The first error of a
/// piece or of the sink, in order, ends it, and so does a break.
///
/// No thread ever waits for another piece: whoever finishes the next one hands
/// over all that are ready. So `work` may use the same pool.
pub(super) fn in_order<R: Send, E: Send>(
    count: u64,
    window: u64,
    work: impl Fn(u64) -> Result<ControlFlow<(), R>, E> + Sync,
    sink: impl FnMut(R) -> Result<(), E> + Send,
) -> Result<ControlFlow<()>, E> {
    let queue = Queue {
        done: VecDeque::new(),
        handed_over: 0,
        begun: window.min(count),
        draining: false,
        outcome: None,
    };
    let line = Line { count, work, sink: Mutex::new(sink), queue: Mutex::new(queue) };
    rayon::scope_fifo(|scope| {
        for piece in 0..window.min(count) {
            let line = &line;
            scope.spawn_fifo(move |scope| line.run(scope, piece));
        }
    });
    let queue = line.queue.into_inner().unwrap_or_else(PoisonError::into_inner);
    queue.outcome.unwrap_or(Ok(ControlFlow::Continue(())))
}

struct Line<R, E, W, S> {
    count: u64,
    work: W,
    sink: Mutex<S>,
    queue: Mutex<Queue<R, E>>,
}

struct Queue<R, E> {
    /// Results from piece `handed_over` on, as far as they are there.
    done: VecDeque<Option<Result<ControlFlow<(), R>, E>>>,
    handed_over: u64,
    begun: u64,
    /// Somebody is handing over.
    draining: bool,
    /// Set where it ended early.
    outcome: Option<Result<ControlFlow<()>, E>>,
}

/// A panic elsewhere ends the bake; what a lock holds stays in order.
fn lock<V>(mutex: &Mutex<V>) -> MutexGuard<'_, V> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<R, E, W, S> Line<R, E, W, S>
where
    R: Send,
    E: Send,
    W: Fn(u64) -> Result<ControlFlow<(), R>, E> + Sync,
    S: FnMut(R) -> Result<(), E> + Send,
{
    fn run<'scope>(&'scope self, scope: &ScopeFifo<'scope>, piece: u64) {
        if lock(&self.queue).outcome.is_some() {
            return;
        }
        let result = (self.work)(piece);
        let mut queue = lock(&self.queue);
        let place = (piece - queue.handed_over) as usize;
        if queue.done.len() <= place {
            queue.done.resize_with(place + 1, || None);
        }
        queue.done[place] = Some(result);
        if queue.draining {
            return;
        }
        queue.draining = true;
        while queue.outcome.is_none()
            && let Some(result) = queue.done.front_mut().and_then(Option::take)
        {
            drop(queue);
            let handed_over = match result {
                Ok(ControlFlow::Continue(result)) => (lock(&self.sink))(result),
                Ok(ControlFlow::Break(())) => {
                    queue = lock(&self.queue);
                    queue.outcome = Some(Ok(ControlFlow::Break(())));
                    break;
                }
                Err(error) => Err(error),
            };
            queue = lock(&self.queue);
            queue.done.pop_front();
            queue.handed_over += 1;
            if let Err(error) = handed_over {
                queue.outcome = Some(Err(error));
            } else if queue.begun < self.count {
                let next = queue.begun;
                queue.begun += 1;
                scope.spawn_fifo(move |scope| self.run(scope, next));
            }
        }
        queue.draining = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn pool(threads: usize) -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    /// A piece that takes longer the lower its number is within its group.
    fn slow(piece: u64) -> u64 {
        (0..(8 - piece % 8) * 20_000).fold(piece, |state, step| state.rotate_left(7) ^ step)
    }

    #[test]
    fn results_come_in_order_and_within_the_window() {
        for (threads, window) in [(1, 1), (1, 4), (4, 1), (4, 3), (4, 100)] {
            let (begun, handed_over) = (AtomicU64::new(0), AtomicU64::new(0));
            let most = AtomicU64::new(0);
            let mut results = Vec::new();
            let outcome = pool(threads).install(|| {
                in_order::<_, ()>(
                    50,
                    window,
                    |piece| {
                        let begun = begun.fetch_add(1, Ordering::SeqCst) + 1;
                        let open = begun - handed_over.load(Ordering::SeqCst);
                        most.fetch_max(open, Ordering::SeqCst);
                        // Work that waits for the pool itself.
                        let both = rayon::join(|| slow(piece), || slow(piece));
                        assert_eq!(both.0, both.1);
                        Ok(ControlFlow::Continue(piece))
                    },
                    |result| {
                        handed_over.fetch_add(1, Ordering::SeqCst);
                        results.push(result);
                        Ok(())
                    },
                )
            });
            assert_eq!(outcome, Ok(ControlFlow::Continue(())));
            assert!(results.into_iter().eq(0..50));
            assert!(most.into_inner() <= window);
        }
    }

    #[test]
    fn the_first_end_in_order_counts() {
        let run = |break_at: u64, fail_at: u64, refuse_at: u64| {
            let mut results = 0;
            let outcome = pool(3).install(|| {
                in_order(
                    20,
                    4,
                    |piece| {
                        slow(piece);
                        match piece {
                            _ if piece == fail_at => Err("work"),
                            _ if piece == break_at => Ok(ControlFlow::Break(())),
                            _ => Ok(ControlFlow::Continue(piece)),
                        }
                    },
                    |piece| {
                        results += 1;
                        if piece == refuse_at { Err("sink") } else { Ok(()) }
                    },
                )
            });
            (outcome, results)
        };
        assert_eq!(run(9, 10, 11), (Ok(ControlFlow::Break(())), 9));
        assert_eq!(run(11, 10, 12), (Err("work"), 10));
        assert_eq!(run(11, 12, 10), (Err("sink"), 11));
        assert_eq!(run(99, 99, 99), (Ok(ControlFlow::Continue(())), 20));
        assert_eq!(
            in_order::<(), ()>(0, 4, |_| Err(()), |()| Err(())),
            Ok(ControlFlow::Continue(()))
        );
    }
}
