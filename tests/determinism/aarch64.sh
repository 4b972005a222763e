#!/usr/bin/env bash
# Builds determinism_hashes for AArch64, runs it by qemu and compares what it prints with what the program of this processor does.
# Usage: aarch64.sh SOURCE BUILD HASHES [JOBS]; HASHES is the program of this processor. Debian's libraries for arm64 are
# downloaded into BUILD/sysroot and change nothing on this machine. Exit code: 0 all the same, 1 not, 3 a program is missing.
set -euo pipefail

source_dir=$1
build_dir=$2
hashes=$3
jobs=${4:-$(nproc)}
sysroot=$build_dir/sysroot

for need in clang++-19:clang-19 ld.lld-19:lld-19 qemu-aarch64-static:qemu-user-static apt-get:apt dpkg:dpkg; do
    if ! command -v "${need%%:*}" >/dev/null; then
        echo "determinism_aarch64: no ${need%%:*} here; install it: apt-get install ${need#*:}" >&2
        exit 3
    fi
done

# A package manager of its own, for another processor and with nothing installed, finds all that the libraries need.
make_sysroot() {
    local apt=$build_dir/apt
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial" "$apt/dpkg"
    : >"$apt/dpkg/status"
    cat >"$apt/apt.conf" <<CONF
APT::Architecture "arm64";
APT::Architectures {"arm64";};
APT::Install-Recommends "false";
Dir::State "$apt";
Dir::State::status "$apt/dpkg/status";
Dir::Cache "$apt/cache";
CONF
    export APT_CONFIG=$apt/apt.conf
    apt-get -qq update
    # Of config/packages.txt: the libraries, but for those of pages and of WebAssembly.
    local libraries
    mapfile -t libraries < <(grep -E '^(lib.*-dev|opencl-headers)$' "$source_dir/config/packages.txt")
    apt-get -qq install --download-only -y libc6-dev libstdc++-12-dev "${libraries[@]}"
    unset APT_CONFIG
    rm -rf "$sysroot"
    mkdir -p "$sysroot.part"
    for package in "$apt"/cache/archives/*.deb; do
        dpkg -x "$package" "$sysroot.part"
    done
    # Links of the libraries lead to this machine's root: they are turned to the new one.
    find "$sysroot.part" -type l -lname '/*' -printf '%p %l\n' | while read -r link target; do
        ln -snf "$(realpath -m --relative-to="$(dirname "$link")" "$sysroot.part$target")" "$link"
    done
    mv "$sysroot.part" "$sysroot"
}

mkdir -p "$build_dir"
if [[ ! -d $sysroot ]]; then
    echo "== libraries for arm64"
    make_sysroot >"$build_dir/sysroot.log" 2>&1 || { tail -n 20 "$build_dir/sysroot.log" >&2; exit 3; }
fi

echo "== aarch64"
log=$build_dir/build.log
cmake -S "$source_dir" -B "$build_dir/build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$source_dir/tests/determinism/aarch64.cmake" \
    -DZONED_SYSROOT="$sysroot" -DZONED_TARGET=generic -DZONED_WERROR=OFF -DZONED_UNITY=ON >"$log" 2>&1 || { tail -n 20 "$log" >&2; exit 3; }
cmake --build "$build_dir/build" --parallel "$jobs" --target determinism_hashes >>"$log" 2>&1 ||
    { tail -n 40 "$log" >&2; exit 1; }

"$hashes" 1 >"$build_dir/here.txt"
qemu-aarch64-static -L "$sysroot" "$build_dir/build/determinism_hashes" 1 >"$build_dir/aarch64.txt"
if diff "$build_dir/here.txt" "$build_dir/aarch64.txt" >"$build_dir/hashes.diff"; then
    echo "   the same as here: $(wc -l <"$build_dir/here.txt") hashes"
else
    echo "   DIFFERS from here, first:"
    head -n 4 "$build_dir/hashes.diff"
    exit 1
fi
