//! Files in a store that counts and fails.

use std::io::Write;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use object_store::{ObjectStore, ObjectStoreExt};

use super::counting_store::{CountingStore, Fault, Tells};
use super::file::RemoteFile;
use super::runtime::wait;
use super::upload::send;
use crate::error::{Error, Result};
use crate::options::RemoteOptions;

const PATH: &str = "maps/key.dsm";

fn content(length: u64, seed: u64) -> Vec<u8> {
    (0..length).map(|at| ((at * 2_654_435_761 + seed) >> 7) as u8).collect()
}

fn quick() -> RemoteOptions {
    RemoteOptions::new().with_retries(2).with_timeout(Duration::from_millis(300))
}

/// A store with a file of this content.
fn store(bytes: &[u8], tells: Tells) -> (Arc<CountingStore>, Arc<dyn ObjectStore>) {
    let store = Arc::new(CountingStore::telling(tells));
    let (filled, bytes) = (Arc::clone(&store), bytes.to_vec());
    wait(async move {
        filled.set(PATH, bytes).await;
        Ok(())
    })
    .unwrap();
    (Arc::clone(&store), store)
}

/// An opened file of this content, whose opening is over.
fn opened(bytes: &[u8], tells: Tells, options: &RemoteOptions) -> (Arc<CountingStore>, RemoteFile) {
    let (counting, store) = store(bytes, tells);
    let file = RemoteFile::of_store(&store, PATH, options).unwrap();
    file.opened();
    counting.asked();
    (counting, file)
}

fn part(bytes: &[u8], range: Range<u64>) -> &[u8] {
    &bytes[range.start as usize..range.end as usize]
}

#[test]
fn the_start_and_the_end_come_with_two_requests() {
    let bytes = content(10_000_000, 1);
    let (counting, store) = store(&bytes, Tells::Etag);
    let file = RemoteFile::of_store(&store, PATH, &quick()).unwrap();
    assert_eq!(file.length(), 10_000_000);
    for range in
        [0..64, 9_999_936..10_000_000, 9_800_000..9_900_000, 9_700_000..9_800_000, 100..200]
    {
        assert_eq!(file.read(range.clone()).unwrap(), part(&bytes, range));
    }
    assert_eq!(counting.asked().len(), 2);
    // Directories that begin before that take one more, with the metadata before them.
    for range in [9_000_000..9_650_000, 8_999_000..9_000_000, 9_650_000..9_700_000] {
        assert_eq!(file.read(range.clone()).unwrap(), part(&bytes, range));
    }
    assert_eq!(counting.asked().len(), 1);
    file.opened();
    assert_eq!(file.read(0..64).unwrap(), part(&bytes, 0..64));
    assert_eq!(counting.asked().as_slice(), std::slice::from_ref(&(0..64)));
}

#[test]
fn every_range_is_right_while_a_file_is_opened() {
    for (seed, length) in [(1, 20_000), (2, 100_000), (3, 5_000_000)] {
        let bytes = content(length, seed);
        let (counting, store) = store(&bytes, Tells::Etag);
        let file = RemoteFile::of_store(&store, PATH, &quick()).unwrap();
        for step in 0..200_u64 {
            let ends = [7919, 104_729].map(|factor| step * step * factor % length);
            let range = ends[0].min(ends[1])..ends[0].max(ends[1]);
            assert_eq!(file.read(range.clone()).unwrap(), part(&bytes, range.clone()), "{range:?}");
        }
        // Up to the size of the end that comes at once, two requests are all of it.
        assert!(length > 64 << 10 || counting.asked().len() == 2);
    }
}

#[test]
fn small_files_come_with_one_request() {
    for length in [1, 100, 16 << 10] {
        let bytes = content(length, 2);
        let (counting, store) = store(&bytes, Tells::Etag);
        let file = RemoteFile::of_store(&store, PATH, &quick()).unwrap();
        assert_eq!(file.read(0..length).unwrap(), bytes);
        assert_eq!(counting.asked().len(), 1);
    }
}

#[test]
fn reads_outside_and_of_nothing_ask_nobody() {
    let (counting, file) = opened(&content(1000, 3), Tells::Etag, &quick());
    assert!(file.read(7..7).unwrap().is_empty());
    #[expect(clippy::reversed_empty_ranges, reason = "callers may")]
    for range in [0..1001, 1001..1002, 5..4, u64::MAX - 1..u64::MAX] {
        assert!(matches!(file.read(range), Err(Error::Range { length: 1000, .. })));
    }
    assert!(counting.asked().is_empty());
}

#[test]
fn what_came_is_kept_when_an_answer_ends_early() {
    let bytes = content(300_000, 4);
    let (counting, file) = opened(&bytes, Tells::Etag, &quick());
    for (faults, expected) in [
        (vec![Fault::Cut(60_000)], vec![1000..201_000, 61_000..201_000]),
        (vec![Fault::Break(5000)], vec![1000..201_000, 6000..201_000]),
        (vec![Fault::Busy, Fault::Cut(0)], vec![1000..201_000; 3]),
        (vec![Fault::Hang, Fault::Busy], vec![1000..201_000; 3]),
        (vec![Fault::Long], vec![1000..201_000, 201_000..201_000]),
    ] {
        counting.fail(faults.clone());
        let range = 1000..201_000;
        assert_eq!(file.read(range.clone()).unwrap(), part(&bytes, range), "{faults:?}");
        let asked = counting.asked();
        // All that was asked for came before the surplus.
        let expected: Vec<_> =
            expected.into_iter().filter(|range: &Range<u64>| !range.is_empty()).collect();
        assert_eq!(asked, expected, "{faults:?}");
        file.forget();
    }
}

#[test]
fn attempts_end() {
    let bytes = content(300_000, 5);
    let (counting, file) = opened(&bytes, Tells::Etag, &quick());
    for (fault, expected) in [
        (Fault::Cut(10), "30 of 1000 bytes came, tried 3 times"),
        (Fault::Hang, "no answer within 0.3 s, tried 3 times"),
        (Fault::Busy, "does not answer as it should, tried 3 times"),
    ] {
        counting.fail(vec![fault; 3]);
        let begun = Instant::now();
        let error = file.read(5000..6000).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
        assert!(begun.elapsed() < Duration::from_secs(10));
        assert_eq!(counting.asked().len(), 3);
        // The next read asks again.
        assert_eq!(file.read(5000..6000).unwrap(), part(&bytes, 5000..6000));
        assert_eq!(counting.asked().len(), 1);
        file.forget();
    }
    // What will not pass is not tried again.
    counting.fail([Fault::Status(400)]);
    assert!(file.read(5000..6000).is_err());
    assert_eq!(counting.asked().len(), 1);
}

#[test]
fn a_replaced_object_is_an_error_and_never_a_mixture() {
    let (old, new) = (content(300_000, 6), content(300_000, 7));
    for tells in [Tells::Etag, Tells::WeakEtag, Tells::Time] {
        for fault in [Fault::Replaced(new.clone()), Fault::ReplacedUnseen(new.clone())] {
            let (counting, file) = opened(&old, tells, &quick());
            assert_eq!(file.read(1000..2000).unwrap(), part(&old, 1000..2000));
            // A clock tick, where a time is all that is told.
            std::thread::sleep(Duration::from_millis(20));
            counting.fail([fault.clone()]);
            let changed = |range| matches!(file.read(range), Err(Error::Shared(error)) if matches!(*error, Error::Changed));
            assert!(changed(50_000..60_000), "{tells:?} {fault:?}");
            // And so it stays.
            assert!(changed(70_000..80_000), "{tells:?} {fault:?}");
        }
    }
    // In the middle of an answer that is taken up again.
    let (counting, file) = opened(&old, Tells::Etag, &quick());
    counting.fail([Fault::Cut(100), Fault::ReplacedUnseen(new.clone())]);
    assert!(file.read(50_000..60_000).is_err());
    // Of another length: told even by a server that tells nothing else.
    let (counting, file) = opened(&old, Tells::Nothing, &quick());
    counting.fail([Fault::Replaced(content(300_001, 8))]);
    assert!(file.read(50_000..60_000).is_err());
    assert!(file.remark().unwrap().contains("neither"));
}

#[test]
fn a_replacement_while_it_is_opened_is_told() {
    let (old, new) = (content(300_000, 6), content(300_000, 7));
    let (counting, store) = store(&old, Tells::Etag);
    let file = RemoteFile::of_store(&store, PATH, &quick()).unwrap();
    counting.fail([Fault::Replaced(new)]);
    assert!(matches!(file.read(299_000..300_000), Err(Error::Changed)));
}

#[test]
fn a_missing_object_and_an_empty_one_are_errors() {
    let (_, store) = store(&[], Tells::Etag);
    assert!(matches!(RemoteFile::of_store(&store, PATH, &quick()), Err(Error::Empty)));
    let missing = RemoteFile::of_store(&store, "elsewhere", &quick());
    assert!(matches!(missing, Err(Error::NotFound(_))));
}

#[test]
fn threads_that_scan_take_few_requests_and_the_right_bytes() {
    let bytes = content(4_000_000, 9);
    let (counting, file) = opened(&bytes, Tells::Etag, &quick());
    std::thread::scope(|scope| {
        for thread in 0..4_u64 {
            let (file, bytes) = (&file, &bytes);
            scope.spawn(move || {
                for tile in thread * 250..(thread + 1) * 250 {
                    let range = tile * 4000..(tile + 1) * 4000;
                    assert_eq!(file.read(range.clone()).unwrap(), part(bytes, range));
                }
            });
        }
    });
    let asked = counting.asked();
    assert!(asked.len() < 150, "{}", asked.len());
    let statistics = file.statistics();
    assert!(statistics.bytes <= 4_000_000 * 13 / 10, "{statistics:?}");
}

#[test]
fn the_disk_answers_the_second_time() {
    let folder = tempfile::tempdir().unwrap();
    let options = quick().with_disk_cache(folder.path(), 10 << 20);
    let bytes = content(300_000, 10);
    let (counting, store) = store(&bytes, Tells::Etag);
    for round in 0..2 {
        let file = RemoteFile::of_store(&store, PATH, &options).unwrap();
        file.opened();
        counting.asked();
        for tile in 0..20 {
            let range = tile * 10_000..(tile + 1) * 10_000;
            assert_eq!(file.read(range.clone()).unwrap(), part(&bytes, range));
        }
        assert_eq!(counting.asked().is_empty(), round == 1);
        assert_eq!(file.statistics().disk_hits, 20 * round);
    }
    // Another version has entries of its own.
    let new = content(300_000, 11);
    let (filled, again) = (Arc::clone(&counting), new.clone());
    wait(async move {
        filled.set(PATH, again).await;
        Ok(())
    })
    .unwrap();
    let file = RemoteFile::of_store(&store, PATH, &options).unwrap();
    file.opened();
    assert_eq!(file.read(0..10_000).unwrap(), part(&new, 0..10_000));
    assert_eq!(file.statistics().disk_hits, 0);
}

#[test]
fn a_caller_in_a_runtime_of_its_own_is_served() {
    let bytes = content(300_000, 12);
    let (_, file) = opened(&bytes, Tells::Etag, &quick());
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    let read = runtime.block_on(async { file.read(0..100) });
    assert_eq!(read.unwrap(), part(&bytes, 0..100));
}

#[test]
fn files_arrive_whole_in_parts_and_at_once() {
    let bytes = content(100_000, 13);
    let mut file = tempfile::tempfile().unwrap();
    file.write_all(&bytes).unwrap();
    for size in [None, Some(200_000), Some(100_000), Some(30_000), Some(7)] {
        let (_, store) = store(&[], Tells::Etag);
        let part = if size == Some(7) { Some(7_000) } else { size };
        send(&mut file, Arc::clone(&store), PATH.into(), 100_000, part).unwrap();
        let sent: Result<Vec<u8>> = wait(async move {
            let answer = store.get(&PATH.into()).await.unwrap();
            Ok(answer.bytes().await.unwrap().to_vec())
        });
        assert_eq!(sent.unwrap(), bytes, "{part:?}");
    }
}
