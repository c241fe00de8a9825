//! Files of layered maps with numbers changed behind right checksums: no reader
//! panics, and what is called sound can be read.

use std::sync::LazyLock;

use dsm_core::Rgb;
use dsm_io::Packing;
use dsm_tests::forge::Forge;
use dsm_tests::fuzz::read_any_kind;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::examples::{KINDS, file};

fn config() -> ProptestConfig {
    let long = std::env::var_os("DSM_LONG_TESTS").is_some_and(|value| value == "1");
    ProptestConfig {
        cases: if long { 20_000 } else { 1024 },
        rng_seed: RngSeed::Fixed(0x1a7e_12ed),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Every kind, mono and coloured, plain and packed.
static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let blocks = [Packing::Plain, Packing::Zstd];
    let of = |kind| blocks.map(|packing| [file::<f32>(kind, packing), file::<Rgb>(kind, packing)]);
    KINDS.into_iter().flat_map(of).flatten().collect()
});

/// Words that readers stumble over.
fn word() -> impl Strategy<Value = u32> {
    prop_oneof![
        any::<u32>(),
        0_u32..40,
        any::<f32>().prop_map(f32::to_bits),
        (0_u32..32).prop_map(|bit| 1 << bit),
        Just(f32::NAN.to_bits()),
        Just((-0.0_f32).to_bits()),
        Just(1.0_f32.to_bits()),
    ]
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn changed_words_are_read_or_refused(
        file in 0_usize..24,
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..3, word()), 1..4),
    ) {
        let mut forge = Forge(FILES[file].clone());
        let metadata = forge.section(b"META");
        // A payload, its directory entry, and all that is no tile.
        let places = [
            (forge.payload(0), forge.u64(forge.tile_entry(0) + 8) as usize),
            (forge.tile_entry(0) + 8, 52),
            (metadata, forge.0.len() - metadata),
        ];
        for (at, place, word) in changes {
            let (start, length) = places[place];
            forge.put(start + 4 * at.index(length / 4), word.to_le_bytes());
        }
        read_any_kind(forge.sign());
    }
}
