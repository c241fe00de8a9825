#!/usr/bin/env bash
# Compares include/deepshadow.h with what the source says, or with --write makes it. A change needs
# another number in ds_abi_version, which is kept in abi.txt with the header's checksum.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

made=$(mktemp)
trap 'rm -f "$made"' EXIT
cbindgen --quiet --config cbindgen.toml --output "$made" .

version=$(sed -n '/fn ds_abi_version/,/^}/s/^    \([0-9]\+\)$/\1/p' src/border/guard.rs)
# What programs are compiled against: comments may change.
interface=$(sed -E 's|//.*||' "$made" | tr -s '[:space:]' ' ' | sha256sum | cut -c1-16)
kept=$(grep -E "^$version " abi.txt || true)

if [[ ${1:-} == --write ]]; then
    if [[ -n $kept && $kept != "$version $interface" ]]; then
        echo "the interface is another: ds_abi_version has to be more than $version" >&2
        exit 1
    fi
    [[ -n $kept ]] || echo "$version $interface" >>abi.txt
    cp "$made" include/deepshadow.h
    exit
fi
diff -u include/deepshadow.h "$made" || { echo "include/deepshadow.h is not what the source says: check_header.sh --write" >&2; exit 1; }
[[ $kept == "$version $interface" ]] || { echo "the interface of version $version is another than abi.txt has" >&2; exit 1; }
echo "include/deepshadow.h is what the source says, version $version"
