"""The checks of packages notice what they are for."""

import tempfile
import unittest
from pathlib import Path

import check_packages as check
from spdx import NoExpression, is_allowed

ARCHITECTURE = """# Architecture

## Dependencies

| crate | why |
|---|---|
| `glam` | vectors |
| `serde`, `serde_json` | metadata |
| `empty` |  |

## More

| `elsewhere` | not a dependency |
"""


def package(**changed):
    sound = {
        "name": "one",
        "version": "0.1.0",
        "source": None,
        "description": "A crate",
        "keywords": ["shadow-map"],
        "categories": ["rendering"],
        "license": "MIT OR Apache-2.0",
        "readme": "README.md",
        "rust_version": "1.95",
        "dependencies": [],
    }
    return sound | changed


class Licences(unittest.TestCase):
    def test_one_of_or_and_all_of_and_must_be_allowed(self):
        for expression in (
            "MIT",
            "MIT/Apache-2.0",
            "GPL-3.0-only OR MIT",
            "(MIT OR GPL-3.0-only) AND Unicode-3.0",
            "Apache-2.0 WITH LLVM-exception",
        ):
            self.assertTrue(is_allowed(expression), expression)
        for expression in (
            "GPL-3.0-only",
            "MIT AND GPL-3.0-only",
            "(MIT AND GPL-3.0-only) OR LGPL-2.1-only",
            "MIT AND (MPL-2.0 OR GPL-2.0-only)",
            "MIT WITH Classpath-exception-2.0",
        ):
            self.assertFalse(is_allowed(expression), expression)

    def test_nonsense_is_no_expression(self):
        for expression in ("", "MIT OR", "(MIT", "MIT)", "AND MIT", "MIT Apache-2.0"):
            with self.assertRaises(NoExpression, msg=expression):
                is_allowed(expression)

    def test_foreign_packages_need_one(self):
        registry = {"source": "registry"}
        self.assertEqual(list(check.licence_problems([package(**registry), package(license=None)])), [])
        for licence in (None, "SSPL-1.0", "MIT OR"):
            self.assertEqual(len(list(check.licence_problems([package(**registry, license=licence)]))), 1, licence)


class Reasons(unittest.TestCase):
    def test_each_dependency_has_one_and_each_reason_a_dependency(self):
        used = {"glam": "1", "serde": {"version": "1"}, "serde_json": "1", "own": {"path": "own", "version": "0.1.0"}}
        self.assertEqual(list(check.reason_problems(used, ARCHITECTURE)), [])
        for name in ("rayon", "empty", "elsewhere"):
            self.assertEqual(len(list(check.reason_problems(used | {name: "1"}, ARCHITECTURE))), 1, name)
        del used["glam"]
        self.assertEqual(len(list(check.reason_problems(used, ARCHITECTURE))), 1)


class Metadata(unittest.TestCase):
    def test_each_field_is_needed(self):
        self.assertEqual(list(check.metadata_problems(package())), [])
        for field in check.FIELDS:
            empty = [] if field in ("keywords", "categories") else None
            self.assertEqual(list(check.metadata_problems(package(**{field: empty}))), [f"one: no {field}"])

    def test_keywords_and_categories_are_those_of_the_registry(self):
        for changed in (
            {"keywords": ["a", "b", "c", "d", "e", "f"]},
            {"keywords": ["deep shadow"]},
            {"keywords": ["longer-than-20-letters"]},
            {"categories": ["shadows"]},
        ):
            self.assertEqual(len(list(check.metadata_problems(package(**changed)))), 1, changed)

    def test_paths_have_versions_but_where_only_tests_need_them(self):
        def needs(kind, requirement):
            return package(dependencies=[{"name": "two", "path": "/two", "kind": kind, "req": requirement}])

        self.assertEqual(len(list(check.metadata_problems(needs(None, "*")))), 1)
        for sound in (needs(None, "^0.1.0"), needs("dev", "*")):
            self.assertEqual(list(check.metadata_problems(sound)), [])


class Files(unittest.TestCase):
    def test_licences_are_real_copies(self):
        with tempfile.TemporaryDirectory() as folder:
            root, crate = Path(folder), Path(folder, "crate")
            crate.mkdir()
            for file in check.LICENCES:
                (root / file).write_text(file)
                (crate / file).write_text(file)
            self.assertEqual(list(check.licence_file_problems(crate, root)), [])
            (crate / check.LICENCES[0]).write_text("another")
            self.assertEqual(len(list(check.licence_file_problems(crate, root))), 1)
            (crate / check.LICENCES[0]).unlink()
            (crate / check.LICENCES[1]).unlink()
            (crate / check.LICENCES[1]).symlink_to(root / check.LICENCES[1])
            self.assertEqual(len(list(check.licence_file_problems(crate, root))), 2)

    def test_packages_hold_what_they_need_and_no_more(self):
        sound = ["Cargo.toml", "README.md", *check.LICENCES, "src/lib.rs"]
        self.assertEqual(list(check.content_problems("one", sound)), [])
        self.assertEqual(len(list(check.content_problems("one", sound[1:]))), 1)
        self.assertEqual(len(list(check.content_problems("one", [*sound, "tests/data/a.exr"]))), 1)


if __name__ == "__main__":
    unittest.main()
