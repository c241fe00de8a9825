# What the scripts of this folder share: a temporary folder that goes away at the end, and the installs.
# Sourced, not run.

set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export PYTHONPATH="$here" PYTHONDONTWRITEBYTECODE=1

# A virtual environment with the packages named, each with its version: python_with numpy==2.4.6 ...
# `$python` runs it. Blender's module needs Python 3.11.
python_with() {
    python3 -m venv "$work/venv"
    "$work/venv/bin/pip" install --quiet --disable-pip-version-check "$@"
    python="$work/venv/bin/python"
    echo "packages: $*"
}

# Debian's packages, each with the version that the script was written with: debian_with openexr 3.1.5-5 ...
debian_with() {
    while [ $# -gt 0 ]; do
        dpkg-query -W "$1" >/dev/null 2>&1 || apt-get install --yes --quiet=2 "$1" >/dev/null
        echo "package: $1 $(dpkg-query -W -f '${Version}' "$1") (written with $2)"
        shift 2
    done
}

# npm packages, each with its version, in `$work/node`: node_with three@0.187.0 ...
node_with() {
    mkdir -p "$work/node"
    (cd "$work/node" && npm init --yes >/dev/null && npm install --silent "$@")
    echo "packages: $*"
}
