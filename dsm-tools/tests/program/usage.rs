//! What no command does.

use crate::run;

#[test]
fn help_and_version_are_no_errors() {
    assert!(run!("--help").stdout().contains("lookup"));
    assert!(run!("lookup", "--help").stdout().contains("--points"));
    assert_eq!(run!("--version").stdout(), format!("dsm-tools {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn wrong_usage_has_exit_code_2() {
    let none: [&str; 0] = [];
    assert_eq!(run::run(none).code, 2);
    run!("paint").is_wrong_usage("paint");
    run!("lookup", "map.dsm").is_wrong_usage("--points");
    run!("verify").is_wrong_usage("FILE");
    run!("inspect", "a.dsm", "b.dsm").is_wrong_usage("b.dsm");
}

/// A switch comes with what it switches: taken and ignored, it would lie.
#[test]
fn what_is_not_there_is_not_accepted() {
    run!("render", "a", "-o", "b.png", "--crop", "0").is_wrong_usage("--crop");
    run!("lookup", "a", "--points", "b", "--accumulate", "add").is_wrong_usage("--accumulate");
    for method in ["prefilter", "attenuation", "coherence", "hybrid"] {
        run!("lookup", "a", "--points", "b", "--method", method).is_wrong_usage(method);
    }
}
