"""Holds the workspace's packages to what a release needs.

Licences of all dependencies, a reason for each direct one, the metadata of every package that is
published, and what lies in it.
"""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

from spdx import NoExpression, is_allowed

ROOT = Path(__file__).resolve().parents[2]
LICENCES = ("LICENSE-APACHE", "LICENSE-MIT")
FIELDS = ("description", "keywords", "categories", "license", "readme", "rust_version")
# The registry refuses others; those of its list that fit here.
CATEGORIES = {
    "algorithms",
    "command-line-utilities",
    "development-tools::testing",
    "encoding",
    "graphics",
    "multimedia::images",
    "rendering",
    "rendering::data-formats",
}


def licence_problems(packages):
    """What is wrong with the licences of packages that come from elsewhere."""
    for package in packages:
        if package["source"] is None:
            continue
        name = f"{package['name']} {package['version']}"
        expression = package["license"]
        try:
            if not expression:
                yield f"{name}: states no licence"
            elif not is_allowed(expression):
                yield f"{name}: its licence is not on the list: {expression}"
        except NoExpression:
            yield f"{name}: not a licence expression: {expression}"


def reason_problems(dependencies, architecture):
    """Direct dependencies (the workspace's table) without a reason in docs/ARCHITECTURE.md, and reasons without one."""
    foreign = {name for name, wanted in dependencies.items() if "path" not in dict_of(wanted)}
    rows = re.findall(r"^\| (`.*?`) \| (.*) \|$", section(architecture, "Dependencies"), re.MULTILINE)
    given = {name for names, reason in rows if reason.strip() for name in re.findall(r"`([^`]+)`", names)}
    for name in sorted(foreign - given):
        yield f"{name}: docs/ARCHITECTURE.md gives no reason for it"
    for name in sorted(given - foreign):
        yield f"{name}: docs/ARCHITECTURE.md gives a reason, and nothing depends on it"


def dict_of(wanted):
    return wanted if isinstance(wanted, dict) else {}


def section(text, title):
    found = re.search(rf"^## {re.escape(title)}$(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    return found.group(1) if found else ""


def metadata_problems(package):
    """What a package to publish does not say of itself, or says so that the registry refuses it."""
    name = package["name"]
    for field in FIELDS:
        if not package[field]:
            yield f"{name}: no {field}"
    keywords = package["keywords"]
    if len(keywords) > 5:
        yield f"{name}: more than 5 keywords"
    for keyword in keywords:
        if not re.fullmatch(r"[a-z0-9][a-z0-9_+-]{0,19}", keyword):
            yield f"{name}: not a keyword: {keyword}"
    for category in package["categories"]:
        if category not in CATEGORIES:
            yield f"{name}: not a known category: {category}"
    for dependency in package["dependencies"]:
        # Cargo leaves out what only tests need, if it has no version.
        if dependency.get("path") and dependency["kind"] != "dev" and dependency["req"] == "*":
            yield f"{name}: {dependency['name']} has a path and no version"


def licence_file_problems(folder, root):
    """Licence files of a package that are missing, links, or not the workspace's."""
    for file in LICENCES:
        copy = folder / file
        if not copy.is_file() or copy.is_symlink():
            yield f"{copy}: must be a copy of the workspace's"
        elif copy.read_bytes() != (root / file).read_bytes():
            yield f"{copy}: differs from the workspace's"


def content_problems(name, files):
    """What lies in a package that should not, and the reverse."""
    for file in ("Cargo.toml", "README.md", *LICENCES):
        if file not in files:
            yield f"{name}: the package has no {file}"
    known = ("Cargo.toml", "Cargo.toml.orig", "Cargo.lock", ".cargo_vcs_info.json", "README.md", "build.rs", *LICENCES)
    for file in files:
        if file not in known and not file.startswith(("src/", "examples/")):
            yield f"{name}: the package holds {file}"


def cargo(*arguments):
    return subprocess.run(["cargo", *arguments], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def problems():
    packages = json.loads(cargo("metadata", "--locked", "--all-features", "--format-version", "1"))["packages"]
    yield from licence_problems(packages)
    manifest = tomllib.loads((ROOT / "Cargo.toml").read_text())
    architecture = (ROOT / "docs" / "ARCHITECTURE.md").read_text()
    yield from reason_problems(manifest["workspace"]["dependencies"], architecture)
    for package in packages:
        if package["source"] is None and package["publish"] != []:
            name = package["name"]
            yield from metadata_problems(package)
            yield from licence_file_problems(Path(package["manifest_path"]).parent, ROOT)
            files = cargo("package", "--list", "--quiet", "--locked", "--allow-dirty", "--package", name).splitlines()
            yield from content_problems(name, files)


def main():
    found = list(problems())
    for problem in found:
        print(problem, file=sys.stderr)
    if found:
        sys.exit(1)
    print("licences, reasons, metadata and contents of all packages are as they must be")


if __name__ == "__main__":
    main()
