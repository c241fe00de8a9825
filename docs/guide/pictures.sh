#!/usr/bin/env bash
# Makes the pictures of lighting.md and prints their errors: pictures.sh PROGRAM [FOLDER]
set -euo pipefail
program=$(realpath "$1")
images=$(realpath "${2:-$(dirname "${BASH_SOURCE[0]}")/../images}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

size=(--resolution 240x180 --samples 8)

# The truth of a scene: rays through it, to a light of this size.
truth() {
    "$program" render "builtin:$1" -o "truth-$1-$2.exr" "${size[@]}" --quiet --method reference --light-size "$2" --rays 144
}

# A picture with a map of its own, and its error: picture NAME SCENE LIGHT "BAKE SWITCHES" "RENDER SWITCHES"
picture() {
    local name=$1 scene=$2 light=$3
    [[ -e truth-$scene-$light.exr ]] || truth "$scene" "$light"
    # shellcheck disable=SC2086 # Switches are words.
    "$program" bake "builtin:$scene" -o map.dsm --quiet $4
    # shellcheck disable=SC2086
    "$program" render "builtin:$scene" --map map.dsm -o "$images/guide-$name.png" "${size[@]}" --quiet --light-size "$light" $5 \
        --compare "truth-$scene-$light.exr" 2>/dev/null |
        sed -n "s/.*RMSE \([0-9.]*\).*/$name \1 $(stat -c %s map.dsm)/p"
}

picture hair-few hairball 0 "--resolution 48" ""
picture hair-enough hairball 0 "--resolution 512" ""
picture samples-few fur-plane 0 "--resolution 256 --samples 1" ""
picture samples-enough fur-plane 0 "--resolution 256 --samples 16" ""
picture bias-none foliage 0 "" "--bias 0"
picture bias-auto foliage 0 "" ""
picture light-point foliage 1 "" ""
picture light-wide foliage 1 "--kind fragments" "--method trace --rays 64"
picture lookup foliage 1 "--kind prefiltered" "--method prefilter"
picture smoke-loose smoke 0 "--tolerance 0.3 --samples 4 --resolution 128" ""
picture smoke-tight smoke 0 "--tolerance 0.01 --resolution 256" ""
picture glass-mono stained-glass 0 "--channels mono" ""
picture glass-rgb stained-glass 0 "" ""
