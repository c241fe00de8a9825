//! The inputs that fuzzing found worth keeping, through its targets.

use std::fs;
use std::path::Path;

use dsm_tests::fuzz::TARGETS;

#[test]
fn kept_inputs_are_read_or_refused() {
    for (name, target) in TARGETS {
        // Whole volumes and stages are read beside the crate that has them.
        let folders = match name {
            "vdb" => vec!["../dsm-scene/tests/data/volumes".to_owned()],
            "usd" => vec![
                "data/fuzz/usd".to_owned(),
                "../dsm-scene/tests/data/usd/text".to_owned(),
                "../dsm-scene/tests/data/usd/binary".to_owned(),
                "../dsm-scene/tests/data/usd/packed".to_owned(),
            ],
            name => vec![format!("data/fuzz/{name}")],
        };
        let (mut inputs, mut accepted) = (0, 0);
        for folder in &folders {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
            for file in fs::read_dir(&folder).unwrap() {
                let path = file.unwrap().path();
                if name == "vdb" && path.extension().is_none_or(|extension| extension != "vdb") {
                    continue;
                }
                let bytes = fs::read(&path).unwrap();
                let outcome = std::panic::catch_unwind(|| target(&bytes));
                assert!(outcome.is_ok(), "{}", path.display());
                accepted += usize::from(outcome.is_ok_and(|accepted| accepted));
                inputs += 1;
            }
        }
        assert!(inputs >= 10, "{folders:?} hold {inputs}");
        assert!(accepted >= 3, "{name}: {accepted} of {inputs} accepted");
    }
}
