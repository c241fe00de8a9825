#!/usr/bin/env bash
# Builds the wheel for manylinux_2_28 and tests it from a fresh virtual environment.
#
# check.sh PYTHON TOOLS FOLDER: an interpreter with the packages of requirements-test.txt, the
# program dsm-tools, and a folder for the wheel and the environment.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
python=$1
tools=$(realpath "$2")
folder=$(mkdir -p "$3" && cd "$3" && pwd)

# A target folder of its own: builds with other flags in one folder undo each other.
rm -rf "$folder/wheels" "$folder/venv"
# Readers of pictures are compiled without optimisation elsewhere, which takes less time and more room.
small=()
for package in image moxcms pxfm; do
    small+=(--config "profile.release.package.$package.opt-level=\"s\"")
done
PATH=$(dirname "$(realpath -s "$python")"):$PATH maturin build --release --locked --zig --compatibility manylinux_2_28 \
    --compression-level 9 "${small[@]}" --manifest-path "$here/Cargo.toml" --target-dir "$folder/target" --out "$folder/wheels"
wheel=$(echo "$folder"/wheels/*.whl)
[[ $wheel == *-cp310-abi3-manylinux_2_28_x86_64.whl || $wheel == *-cp310-abi3-manylinux_2_28_aarch64.whl ]] || { echo "not for every Python and glibc 2.28: $wheel" >&2; exit 1; }
size=$(stat -c %s "$wheel")
((size < 5000000)) || { echo "the wheel has $size bytes" >&2; exit 1; }

"$python" -m venv "$folder/venv"
pip=("$folder/venv/bin/python" -m pip --disable-pip-version-check)
"${pip[@]}" install --quiet "$wheel"
# numpy alone comes with it.
others=$("${pip[@]}" list --format=freeze | grep -vE '^(deepshadow|numpy|pip|setuptools)==' || true)
[[ -z $others ]] || { echo "the wheel brought $others" >&2; exit 1; }
"$folder/venv/bin/python" -c 'import deepshadow; print(deepshadow.__version__, *deepshadow.KINDS)'
"${pip[@]}" install --quiet -r "$here/requirements-test.txt"
echo "wheel: $size bytes"

cd "$here/tests"
DSM_TOOLS=$tools "$folder/venv/bin/python" -m pytest -q -p no:cacheprovider .
