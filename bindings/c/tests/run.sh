#!/usr/bin/env bash
# Builds the examples through pkg-config and through CMake against an installed libdeepshadow, and
# runs them under valgrind.
#
# run.sh BUILT: the folder with libdeepshadow.so and .a. CMAKE names another cmake.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
built=$(cd "$1" && pwd)
cmake=${CMAKE:-cmake}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$here/install.sh" "$work/prefix" "$built"
export PKG_CONFIG_PATH=$work/prefix/lib/pkgconfig LD_LIBRARY_PATH=$work/prefix/lib
flags=(-O1 -g -Wall -Wextra -Wpedantic -Werror)

foreign=$(nm -D --defined-only "$work/prefix/lib/libdeepshadow.so" | awk '{print $3}' | grep -v '^ds_' || true)
[[ -z $foreign ]] || { echo "libdeepshadow.so exports what is not ds_*: $foreign" >&2; exit 1; }
readelf -d "$work/prefix/lib/libdeepshadow.so" | grep -q 'SONAME.*\[libdeepshadow\.so\.0\]' || { echo "no soname" >&2; exit 1; }

# Threads of a pool that waits for more work are no leak of a program.
checked() {
    RAYON_NUM_THREADS=2 valgrind --quiet --error-exitcode=9 --leak-check=full --show-leak-kinds=definite,indirect --errors-for-leak-kinds=definite,indirect "$@"
}

mkdir "$work/out"
cc -std=c99 "${flags[@]}" "$here/examples/lookup.c" -o "$work/lookup" $(pkg-config --cflags --libs deepshadow)
c++ -std=c++17 "${flags[@]}" "$here/examples/hits.cpp" -o "$work/hits" $(pkg-config --cflags --libs deepshadow)
checked "$work/lookup" "$work/out/sphere.dsm"
checked "$work/hits" "$work/out"

# The recipe of the README.
sed -n '/^```c$/,/^```$/{/^```/d;p}' "$here/../../README.md" >"$work/use.c"
cc -std=c99 "${flags[@]}" "$work/use.c" -o "$work/use" $(pkg-config --cflags --libs deepshadow)
cp "$work/out/sphere.dsm" "$work/out/key.dsm"
(cd "$work/out" && [[ $("$work/use") == [01]* ]]) || { echo "the README's recipe does not answer" >&2; exit 1; }

"$cmake" -S "$here/examples" -B "$work/cmake" -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/cmake.log" || { cat "$work/cmake.log"; exit 1; }
"$cmake" --build "$work/cmake" >>"$work/cmake.log" || { cat "$work/cmake.log"; exit 1; }
for example in lookup lookup_static; do
    "$work/cmake/$example" "$work/out/sphere.dsm" >/dev/null
done
"$work/cmake/hits" "$work/out" >/dev/null
echo "examples: through pkg-config under valgrind, and through CMake"

if c++ -E -include embree3/rtcore.h -x c++ /dev/null >/dev/null 2>&1; then
    cc -std=c99 "${flags[@]}" "$here/examples/embree.c" -o "$work/embree" $(pkg-config --cflags --libs deepshadow) -lembree3 -lm
    "$work/embree" "$work/out/soup.dsm"
else
    echo "SKIPPED: Embree's header is not there"
fi
