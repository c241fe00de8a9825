#!/usr/bin/env bash
# zarr 3.1.6 with numcodecs 0.16.6 and zfpy 1.0.1.post0 (PyPI).
#
# zfpy is an optional codec of numcodecs; nothing here uses it.
# Guess: `import zarr` works with and without zfpy installed (an optional codec that can't be used is left out).
# Seen:  with zfpy 1.0.1.post0 `import zarr` raises ValueError: numcodecs reads zfpy's version as whole numbers between
#        dots, and "post0" is none. Every zarr file of that environment is shut, for a codec that none of them uses.
. "$(dirname "$0")/lib.sh"
python_with zarr==3.1.6 numcodecs==0.16.6 numpy==2.4.6
try() { if "$python" -c 'import zarr' 2>"$work/error"; then echo imported; else tail -n 1 "$work/error"; fi; }
before=$(try)
"$work/venv/bin/pip" install --quiet --disable-pip-version-check zfpy==1.0.1.post0
after=$(try)
echo "question: import zarr, without and with zfpy 1.0.1.post0"
echo "guess:    imported; imported"
echo "seen:     $before; $after"
[ "$before; $after" = "imported; ValueError: invalid literal for int() with base 10: 'post0'" ] || { echo CHANGED; exit 1; }
