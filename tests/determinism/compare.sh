#!/usr/bin/env bash
# Builds determinism_hashes with two compilers, two optimisations and for three processors, and compares what they print.
# Usage: compare.sh SOURCE BUILD [JOBS]. Exit code: 0 all the same, 1 not, 3 a compiler is missing.
set -euo pipefail

source_dir=$1
build_dir=$2
jobs=${3:-$(nproc)}
second=${ZONED_SECOND_COMPILER:-clang++-19}

for compiler in g++ "$second"; do
    if ! command -v "$compiler" >/dev/null; then
        echo "determinism: no $compiler here; install it, or name another in ZONED_SECOND_COMPILER" >&2
        exit 3
    fi
done

launcher=()
if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
first=""
failed=0
for build in g++:O1:v3 g++:O3:v3 "$second:O1:v3" "$second:O3:v3" "$second:O2:baseline" "$second:O2:native"; do
    IFS=: read -r compiler level target <<<"$build"
    name="$compiler-$level-$target"
    dir="$build_dir/$name"
    echo "== $name"
    # Without a build type nothing but these flags decides on the optimisation.
    cmake -S "$source_dir" -B "$dir" -G Ninja -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=None \
        -DCMAKE_CXX_FLAGS="-$level" -DZONED_TARGET="$target" -DZONED_WERROR=OFF -DZONED_UNITY=ON "${launcher[@]}" >"$dir.log" 2>&1 ||
        { cat "$dir.log" >&2; exit 3; }
    cmake --build "$dir" --parallel "$jobs" --target determinism_hashes >>"$dir.log" 2>&1 ||
        { tail -n 40 "$dir.log" >&2; exit 1; }
    "$dir/determinism_hashes" >"$dir.txt" || failed=1
    if [[ -z $first ]]; then
        first="$dir.txt"
    elif diff "$first" "$dir.txt" >"$dir.diff"; then
        echo "   the same as ${first##*/}: $(wc -l <"$dir.txt") hashes"
    else
        echo "   DIFFERS from ${first##*/}, first:"
        head -n 4 "$dir.diff"
        failed=1
    fi
done
exit "$failed"
