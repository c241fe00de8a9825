//! The inputs that fuzzing found worth keeping, through its targets.

use std::fs;
use std::path::Path;

use dsm_tests::fuzz::TARGETS;

#[test]
fn kept_inputs_are_read_or_refused() {
    for (name, target) in TARGETS {
        // Whole volumes are read beside the crate that has them.
        let folder = match name {
            "vdb" => "../dsm-scene/tests/data/volumes".to_owned(),
            name => format!("data/fuzz/{name}"),
        };
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let (mut inputs, mut accepted) = (0, 0);
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
        assert!(inputs >= 10, "{} holds {inputs}", folder.display());
        assert!(accepted >= 3, "{name}: {accepted} of {inputs} accepted");
    }
}
