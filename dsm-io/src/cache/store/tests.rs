use std::collections::BTreeSet;
use std::sync::Barrier;
use std::sync::atomic::AtomicUsize;
use std::thread;

use dsm_testkit::config;
use proptest::prelude::*;

use super::*;
use crate::tile_id::TileId;

const THREADS: usize = 8;

fn key(map: u64, x: u32) -> Key {
    Key { map, tile: TileId::new(0, x % 4, x / 4) }
}

/// Asks for a tile that a stand-in is for.
fn get(store: &TileStore, key: Key, bytes: u64) -> Value {
    store.get_or_load(key, 0, || Ok((Arc::new(()) as Value, bytes))).unwrap()
}

fn kept_keys(store: &TileStore) -> BTreeSet<(u64, TileId)> {
    let keys = store.shards.iter().flat_map(|shard| lock(shard).keys());
    keys.map(|key| (key.map, key.tile)).collect()
}

fn remembered(store: &TileStore) -> usize {
    store.shards.iter().map(|shard| lock(shard).remembered()).sum()
}

#[derive(Clone, Debug)]
enum Operation {
    Get(Key),
    Hold(Key),
    ReleaseAll,
    Forget(u64),
}

/// One list, searched from end to end.
struct Naive {
    budget: u64,
    /// Least recently used first.
    kept: Vec<(Key, u64)>,
    held: Vec<Key>,
    statistics: CacheStatistics,
}

impl Naive {
    fn get(&mut self, key: Key, bytes: u64) {
        let position = self.kept.iter().position(|&(other, _)| other == key);
        if position.is_some() || self.held.contains(&key) {
            self.statistics.hits += 1;
        } else {
            self.statistics.misses += 1;
            self.statistics.loads += 1;
        }
        if let Some(position) = position {
            self.kept.remove(position);
        } else if bytes > self.budget {
            return;
        }
        self.kept.push((key, bytes));
        while self.bytes() > self.budget {
            self.kept.remove(0);
            self.statistics.evictions += 1;
        }
    }

    fn bytes(&self) -> u64 {
        self.kept.iter().map(|&(_, bytes)| bytes).sum()
    }
}

fn operation() -> impl Strategy<Value = Operation> {
    let key = || (0..2_u64, 0..10_u32).prop_map(|(map, x)| key(map, x));
    prop_oneof![
        12 => key().prop_map(Operation::Get),
        4 => key().prop_map(Operation::Hold),
        1 => Just(Operation::ReleaseAll),
        1 => (0..2_u64).prop_map(Operation::Forget),
    ]
}

proptest! {
    #![proptest_config(config(0x0d5_cac4e))]

    #[test]
    fn keeps_what_one_naive_list_keeps(
        budget in 0..80_u64,
        operations in proptest::collection::vec(operation(), 1..120),
    ) {
        let bytes_of = |key: Key| 1 + (7 * key.map + 13 * u64::from(key.tile.x + 4 * key.tile.y)) % 31;
        let store = TileStore::new(budget);
        let mut naive =
            Naive { budget, kept: vec![], held: vec![], statistics: CacheStatistics::default() };
        let mut held = Vec::new();
        for operation in operations {
            match operation {
                Operation::Get(key) => {
                    get(&store, key, bytes_of(key));
                    naive.get(key, bytes_of(key));
                }
                Operation::Hold(key) => {
                    held.push(get(&store, key, bytes_of(key)));
                    naive.get(key, bytes_of(key));
                    naive.held.push(key);
                }
                Operation::ReleaseAll => {
                    held.clear();
                    naive.held.clear();
                }
                Operation::Forget(map) => {
                    store.forget(map);
                    naive.kept.retain(|(key, _)| key.map != map);
                    naive.held.retain(|key| key.map != map);
                }
            }
            let expected: BTreeSet<_> =
                naive.kept.iter().map(|(key, _)| (key.map, key.tile)).collect();
            prop_assert_eq!(kept_keys(&store), expected);
            let found = store.statistics();
            prop_assert_eq!(
                CacheStatistics { pinned_tiles: 0, pinned_bytes: 0, peak_bytes: 0, ..found },
                CacheStatistics {
                    tiles: naive.kept.len() as u64,
                    bytes: naive.bytes(),
                    ..naive.statistics
                }
            );
        }
    }
}

/// What each of eight threads gets that ask for one tile while it is loaded.
fn ask_at_once(
    store: &TileStore,
    outcome: impl Fn() -> Result<(Value, u64)> + Sync,
) -> (Vec<Result<Value>>, usize) {
    let (key, loads) = (key(0, 3), AtomicUsize::new(0));
    let ask = || {
        store.get_or_load(key, 0, || {
            loads.fetch_add(1, Ordering::Relaxed);
            while store.shard(key).waiting(key) < THREADS - 1 {
                thread::yield_now();
            }
            outcome()
        })
    };
    let answers = thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS).map(|_| scope.spawn(ask)).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    (answers, loads.into_inner())
}

#[test]
fn a_tile_is_loaded_once_however_many_ask() {
    // Kept, and too large to be kept.
    for budget in [100, 5] {
        let store = TileStore::new(budget);
        let (answers, loads) = ask_at_once(&store, || Ok((Arc::new(()) as Value, 10)));
        assert_eq!(loads, 1);
        let values: Vec<_> = answers.into_iter().map(Result::unwrap).collect();
        assert!(values.iter().all(|value| Arc::ptr_eq(value, &values[0])));
        let statistics = store.statistics();
        assert_eq!((statistics.hits, statistics.misses, statistics.loads), (0, 8, 1));
        assert_eq!(statistics.bytes, if budget == 100 { 10 } else { 0 });
    }
}

#[test]
fn a_failure_is_everybodys_and_then_forgotten() {
    let store = TileStore::new(100);
    let (answers, loads) = ask_at_once(&store, || Err(Error::NoSuchLevel(7)));
    assert_eq!(loads, 1);
    let errors: Vec<_> = answers
        .into_iter()
        .map(|answer| match answer {
            Err(Error::Shared(error)) => error,
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(errors.iter().all(|error| Arc::ptr_eq(error, &errors[0])));
    assert_eq!(errors[0].to_string(), "there is no level 7");
    assert_eq!(remembered(&store), 0);
    get(&store, key(0, 3), 10);
    let statistics = store.statistics();
    assert_eq!((statistics.failed_loads, statistics.loads, statistics.misses), (1, 1, 9));
}

#[test]
fn a_load_that_panics_is_tried_by_who_waits() {
    let store = TileStore::new(100);
    let key = key(0, 0);
    let started = Barrier::new(2);
    let value = thread::scope(|scope| {
        let panicking = scope.spawn(|| {
            store.get_or_load(key, 0, || {
                started.wait();
                while store.shard(key).waiting(key) == 0 {
                    thread::yield_now();
                }
                panic!("as the test wants");
            })
        });
        started.wait();
        let value = get(&store, key, 10);
        assert!(panicking.join().is_err());
        value
    });
    assert!(Arc::ptr_eq(&value, &get(&store, key, 10)));
    assert_eq!((store.statistics().loads, remembered(&store)), (1, 0));
}

#[test]
fn the_budget_holds_at_any_time() {
    const GETS: u32 = 5_000;
    let store = TileStore::new(100);
    let asking = AtomicUsize::new(THREADS);
    thread::scope(|scope| {
        for thread in 0..THREADS as u32 {
            let (store, asking) = (&store, &asking);
            scope.spawn(move || {
                for step in 0..GETS {
                    let x = (step * (2 * thread + 1)).wrapping_mul(0x9E37_79B9) >> 27;
                    get(store, key(0, x), u64::from(1 + x));
                }
                asking.fetch_sub(1, Ordering::Relaxed);
            });
        }
        while asking.load(Ordering::Relaxed) > 0 {
            assert!(store.statistics().bytes <= 100);
            thread::yield_now();
        }
    });
    let statistics = store.statistics();
    assert_eq!(statistics.hits + statistics.misses, u64::from(GETS) * THREADS as u64);
    let bytes: u64 =
        kept_keys(&store).iter().map(|(_, tile)| u64::from(1 + tile.x + 4 * tile.y)).sum();
    assert_eq!(statistics.bytes, bytes, "the kept tiles are those that were counted");
    assert!(statistics.evictions > 0);
}

#[test]
fn nothing_is_remembered_of_tiles_that_are_gone() {
    let store = TileStore::new(5);
    for x in 0..20_000 {
        get(&store, key(0, x), 10);
    }
    assert!(remembered(&store) <= SHARDS * 64, "{}", remembered(&store));
}
