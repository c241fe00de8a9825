//! One range of an object, whatever happens on the way.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use futures_util::StreamExt;
use object_store::path::Path;
use object_store::{GetOptions, GetRange, ObjectMeta, ObjectStore};
use tokio::time::{sleep, timeout};

use super::version::Version;
use crate::error::{Error, Refusal, Result};

/// The first wait between attempts, and the longest.
const WAITS: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(5)];

/// What an attempt has its time for.
const TIMED_BYTES: u64 = 1 << 20;

/// Counts of requests and of the bytes that came.
#[derive(Debug, Default)]
pub(super) struct Counters {
    pub(super) requests: AtomicU64,
    pub(super) bytes: AtomicU64,
}

/// The object that ranges are asked of, and how patiently.
#[derive(Clone, Debug)]
pub(super) struct Requests {
    pub(super) client: Arc<dyn ObjectStore>,
    pub(super) path: Path,
    pub(super) timeout: Duration,
    pub(super) retries: u32,
    pub(super) counters: Arc<Counters>,
}

/// Why an attempt ended.
enum Failure {
    /// Another attempt may do better.
    Passing(Cause),
    Final(Error),
}

enum Cause {
    Timeout,
    Short,
    Store(Refusal),
}

impl Requests {
    /// The first bytes of an object that nothing is known of, `length` of them or all, and
    /// what it is.
    pub(super) async fn begin(&self, length: u64) -> Result<(Vec<u8>, ObjectMeta)> {
        let mut known = None;
        let bytes = self.bring(0..length, &mut known).await?;
        // Nothing comes without it.
        known.map(|meta| (bytes, meta)).ok_or(Error::Changed)
    }

    /// The bytes of a range that lies in the object, of the version that `meta` is of.
    pub(super) async fn range(&self, range: Range<u64>, meta: ObjectMeta) -> Result<Vec<u8>> {
        self.bring(range, &mut Some(meta)).await
    }

    async fn bring(
        &self,
        mut range: Range<u64>,
        known: &mut Option<ObjectMeta>,
    ) -> Result<Vec<u8>> {
        let asked = range.end - range.start;
        let limit = self.timeout.saturating_mul(time_shares(asked));
        let mut bytes = Vec::new();
        let mut wait = WAITS[0];
        for attempt in 1..=self.retries.saturating_add(1) {
            let brought = self.attempt(&mut range, known, &mut bytes);
            let cause = match timeout(limit, brought).await {
                Ok(Ok(())) => return Ok(bytes),
                Ok(Err(Failure::Final(error))) => return Err(error),
                Ok(Err(Failure::Passing(cause))) => cause,
                Err(_) => Cause::Timeout,
            };
            if attempt > self.retries {
                let got = bytes.len() as u64;
                return Err(match cause {
                    Cause::Timeout => Error::Timeout { limit, attempts: attempt },
                    Cause::Short => Error::Short { asked, got, attempts: attempt },
                    Cause::Store(refusal) => Error::Store { attempts: attempt, refusal },
                });
            }
            sleep(wait).await;
            wait = (wait * 2).min(WAITS[1]);
        }
        Ok(bytes)
    }

    /// Asks for what is missing of `range`, which begins after `bytes`, and adds what comes.
    async fn attempt(
        &self,
        range: &mut Range<u64>,
        known: &mut Option<ObjectMeta>,
        bytes: &mut Vec<u8>,
    ) -> Result<(), Failure> {
        let start = range.start + bytes.len() as u64;
        if start >= range.end {
            return Ok(());
        }
        let mut options =
            GetOptions { range: Some(GetRange::Bounded(start..range.end)), ..Default::default() };
        if let Some(meta) = known {
            Version::of(meta).condition(&mut options, meta);
        }
        self.counters.requests.fetch_add(1, Ordering::Relaxed);
        let answer = match self.client.get_opts(&self.path, options).await {
            Ok(answer) => answer,
            Err(error) if known.is_none() && is_past_end(&error) => {
                return Err(Failure::Final(Error::Empty));
            }
            Err(error) => return Err(failure(error)),
        };
        match known {
            Some(meta) if !Version::of(meta).is_of(&answer.meta) => {
                return Err(Failure::Final(Error::Changed));
            }
            Some(_) => {}
            None => {
                // The object may be shorter than what it was asked for without knowing it.
                range.end = range.end.min(answer.meta.size);
                *known = Some(answer.meta.clone());
            }
        }
        if answer.range != (start..range.end) {
            return Err(Failure::Passing(Cause::Short));
        }
        let mut body = answer.into_stream();
        while let Some(part) = body.next().await {
            let part = part.map_err(failure)?;
            self.counters.bytes.fetch_add(part.len() as u64, Ordering::Relaxed);
            let missing = range.end - range.start - bytes.len() as u64;
            if part.len() as u64 > missing {
                let reason = "more bytes came than the answer says";
                return Err(Failure::Passing(Cause::Store(Refusal::from_text(reason))));
            }
            bytes.extend_from_slice(&part);
        }
        let is_whole = bytes.len() as u64 == range.end - range.start;
        if is_whole { Ok(()) } else { Err(Failure::Passing(Cause::Short)) }
    }
}

/// How many shares of time so many bytes have.
fn time_shares(bytes: u64) -> u32 {
    bytes.div_ceil(TIMED_BYTES).clamp(1, u32::MAX.into()) as u32
}

/// The status of a refused request. The client's own type for it is private; its text
/// begins so.
fn status(text: &str) -> Option<&str> {
    text.split("status code: ").nth(1).and_then(|rest| rest.get(..3))
}

/// Whether a range begins behind the object's end.
fn is_past_end(error: &object_store::Error) -> bool {
    let text = error.to_string();
    status(&text) == Some("416") || text.contains("starting at 0, but object was only 0 bytes long")
}

fn failure(error: object_store::Error) -> Failure {
    use object_store::Error as Store;
    let refusal = Refusal::of(&error);
    match error {
        Store::NotFound { .. } => Failure::Final(Error::NotFound(refusal)),
        Store::Precondition { .. } => Failure::Final(Error::Changed),
        Store::PermissionDenied { .. } | Store::Unauthenticated { .. } => {
            Failure::Final(Error::Denied(refusal))
        }
        Store::NotSupported { .. } => Failure::Final(Error::NoRanges),
        error => {
            let text = error.to_string();
            let status = status(&text);
            let is_refused = status.is_some_and(|code| code.starts_with('4'))
                && !matches!(status, Some("408" | "425" | "429"));
            match is_refused {
                true if status == Some("416") => Failure::Final(Error::Changed),
                true => Failure::Final(Error::Store { attempts: 1, refusal }),
                false if text.contains("non-partial response") => Failure::Final(Error::NoRanges),
                false => Failure::Passing(Cause::Store(refusal)),
            }
        }
    }
}
