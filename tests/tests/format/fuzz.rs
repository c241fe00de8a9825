//! No bytes make the reader panic, hang or take memory without limit.

use dsm_io::Packing;
use dsm_tests::fuzz::read_everything;
use proptest::prelude::*;

use crate::examples::{coloured, document, mono};
use dsm_testkit::config;
use dsm_tests::forge::Forge;

#[derive(Clone, Debug)]
enum Value {
    Byte(u8),
    Small(u8),
    Word([u8; 4]),
    Long([u8; 8]),
}

fn value() -> impl Strategy<Value = Value> {
    let long = prop_oneof![
        any::<u64>(),
        (0_u32..64).prop_map(|bit| 1 << bit),
        (0_u32..64).prop_map(|bit| (1 << bit) - 1),
        (0_u64..40).prop_map(|block| block * 64),
    ];
    let word = prop_oneof![
        any::<u32>(),
        any::<f32>().prop_map(f32::to_bits),
        Just(f32::NAN.to_bits()),
        (0_u32..32).prop_map(|bit| 1 << bit),
    ];
    prop_oneof![
        any::<u8>().prop_map(Value::Byte),
        (0_u8..9).prop_map(Value::Small),
        word.prop_map(|word| Value::Word(word.to_le_bytes())),
        long.prop_map(|long| Value::Long(long.to_le_bytes())),
    ]
}

proptest! {
    #![proptest_config(config(0x0d5_f11e))]

    #[test]
    fn signed_mutations(
        file in 0_usize..4,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<bool>(), value()), 1..4),
    ) {
        let mut forge = Forge(match file {
            0 => document().bytes(),
            1 => mono(Packing::Zstd).bytes(),
            2 => coloured(Packing::Plain).bytes(),
            _ => coloured(Packing::Zstd).bytes(),
        });
        for (position, structural, value) in changes {
            // Structures begin at multiples of 4, and most stand at the end.
            let end = forge.0.len() / 8;
            let tail = forge.0.len() - 1152.min(forge.0.len());
            let at = if structural {
                tail + 4 * position.index((forge.0.len() - tail) / 4 - 1)
            } else {
                8 * position.index(end)
            };
            let bytes = match value {
                Value::Byte(byte) | Value::Small(byte) => vec![byte],
                Value::Word(bytes) => bytes.to_vec(),
                Value::Long(bytes) => bytes.to_vec(),
            };
            forge.0[at..at + bytes.len()].copy_from_slice(&bytes);
        }
        read_everything(forge.sign());
    }

    #[test]
    fn any_bytes_behind_the_magic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let start = document().bytes()[..16].to_vec();
        read_everything([start, bytes].concat());
    }
}
