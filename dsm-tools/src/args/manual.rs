//! Tests: `docs/cli.md` says what the definitions say.

use std::collections::BTreeSet;

use clap::CommandFactory;

use super::Arguments;

/// The manual, in a checkout; a package is without.
fn manual() -> Option<String> {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/cli.md")).ok()
}

/// Every `--switch` in a text.
fn switches(text: &str) -> BTreeSet<String> {
    let is_name = |letter: char| letter.is_ascii_lowercase() || letter == '-';
    text.split("--")
        .skip(1)
        .map(|rest| rest.split(|letter| !is_name(letter)).next().unwrap_or_default().to_owned())
        .filter(|name| name.starts_with(|letter: char| letter.is_ascii_lowercase()))
        .collect()
}

#[test]
fn switches_are_found_in_text() {
    let found = switches("dsm-tools x [--json] [--filter-width W|auto] -o A --- --tile");
    assert!(found.iter().eq(["filter-width", "json", "tile"]), "{found:?}");
}

#[test]
fn the_manual_has_every_command_and_switch_and_no_other() {
    let Some(manual) = manual() else { return };
    let mut program = Arguments::command();
    program.build();
    let commands = program.get_subcommands().filter(|command| command.get_name() != "help");
    let mut names = BTreeSet::new();
    for command in commands {
        let name = command.get_name();
        names.insert(name.to_owned());
        let section = manual.split(&format!("\n## {name}\n")).nth(1);
        let section = section.unwrap_or_else(|| panic!("docs/cli.md has no section {name}"));
        let section = section.split("\n## ").next().unwrap_or_default();
        let usage = section.split("```").nth(1).unwrap_or_default();
        assert!(usage.contains(&format!("dsm-tools {name}")), "{name}: {usage}");
        let defined: BTreeSet<String> = command
            .get_arguments()
            .filter(|argument| !argument.is_hide_set())
            .filter_map(|argument| argument.get_long())
            .filter(|long| !["help", "version"].contains(long))
            .map(str::to_owned)
            .collect();
        let told = switches(usage);
        // `-o` stands for `--output`.
        let mut short = defined.clone();
        if usage.contains(" -o ") {
            short.remove("output");
        }
        assert_eq!(told.difference(&defined).collect::<Vec<_>>(), [""; 0], "{name}: not defined");
        assert_eq!(short.difference(&told).collect::<Vec<_>>(), [""; 0], "{name}: not told");
    }
    for line in manual.lines().filter_map(|line| line.strip_prefix("## ")) {
        assert!(names.contains(line), "docs/cli.md has a section {line}, which is no command");
    }
}

/// Defaults and ranges that clap knows are in the section's tables.
#[test]
fn the_manual_has_every_value_of_choices() {
    let Some(manual) = manual() else { return };
    let mut program = Arguments::command();
    program.build();
    for command in program.get_subcommands().filter(|command| command.get_name() != "help") {
        let name = command.get_name();
        let section = manual.split(&format!("\n## {name}\n")).nth(1).unwrap_or_default();
        let section = section.split("\n## ").next().unwrap_or_default();
        for argument in command.get_arguments() {
            for value in argument.get_possible_values() {
                let value = value.get_name();
                let is_flag = ["true", "false"].contains(&value);
                assert!(
                    is_flag || section.contains(value),
                    "{name} {}: {value}",
                    argument.get_id()
                );
            }
        }
    }
}
