#!/usr/bin/env bash
# Installs libdeepshadow, its header, a pkg-config file and a CMake package under a prefix.
#
# install.sh PREFIX [FOLDER]: FOLDER holds libdeepshadow.so and .a, else target/release.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
prefix=$(mkdir -p "$1" && cd "$1" && pwd)
built=${2:-${CARGO_TARGET_DIR:-$here/../../target}/release}
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' "$here/../../Cargo.toml")
major=${version%%.*}
# What a static library needs of the system.
libs="-lgcc_s -lutil -lrt -lpthread -lm -ldl -lc"

install -d "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/deepshadow"
install -m 644 "$here/include/deepshadow.h" "$prefix/include/"
install -m 755 "$built/libdeepshadow.so" "$prefix/lib/libdeepshadow.so.$version"
ln -sf "libdeepshadow.so.$version" "$prefix/lib/libdeepshadow.so.$major"
ln -sf "libdeepshadow.so.$major" "$prefix/lib/libdeepshadow.so"
install -m 644 "$built/libdeepshadow.a" "$prefix/lib/"

fill() {
    sed -e "s|@version@|$version|g" -e "s|@major@|$major|g" -e "s|@prefix@|$prefix|g" -e "s|@libs@|$libs|g" "$1" >"$2"
}
fill "$here/cmake/deepshadow.pc.in" "$prefix/lib/pkgconfig/deepshadow.pc"
fill "$here/cmake/deepshadow-config.cmake.in" "$prefix/lib/cmake/deepshadow/deepshadow-config.cmake"
fill "$here/cmake/deepshadow-config-version.cmake.in" "$prefix/lib/cmake/deepshadow/deepshadow-config-version.cmake"
