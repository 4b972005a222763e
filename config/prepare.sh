#!/usr/bin/env bash
# Installs what is missing (config/packages.txt), configures build/ (where nobody has yet; several sources at a time, which a
# clean build likes) and builds the targets given as arguments ("all" is one).
# Used by server/run.sh and tests/run.sh. Works from any folder; touches no network when nothing is missing.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="${ZONED_BUILD:-$root/build}"

say() { printf '%s\n' "zoned: $*" >&2; }
fail() { say "$*"; exit 3; }

configure=""

missing_packages() {
    local -a wanted
    local installed package
    mapfile -t wanted < <(sed "${needed[@]}" -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' "$root/config/packages.txt")
    # One question for all: a process for each package takes seconds. It fails where one is unknown, and names the others.
    installed=$'\n'"$(dpkg-query -W -f='${Package} ${Status}\n' "${wanted[@]}" 2>/dev/null || true)"$'\n'
    for package in "${wanted[@]}"; do
        [[ "$installed" == *$'\n'"$package install ok installed"$'\n'* ]] || printf '%s\n' "$package"
    done
}

install_missing() {
    local -a missing as_root=()
    command -v dpkg-query >/dev/null || fail "this is no Debian system; install what config/packages.txt lists and run cmake by hand"
    mapfile -t missing < <(missing_packages)
    # What is there now may be looked for again: the client for browsers is built where its compiler is.
    configure="${missing[*]:-}"
    if ((${#missing[@]} == 0)); then
        return
    fi
    say "installing ${missing[*]}"
    if ((EUID != 0)); then
        command -v sudo >/dev/null || fail "packages are missing and neither root nor sudo is at hand; as root: apt-get install ${missing[*]}"
        as_root=(sudo)
    fi
    "${as_root[@]}" apt-get update -q || fail "apt-get update failed; is there a network?"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}" ||
        fail "apt-get install failed; the reason stands above"
}

# Memory decides as well as cores: a compiler process needs up to 2 GB.
parallel_jobs() {
    local cores memory_kb by_memory
    cores="$(nproc)"
    memory_kb="$(sed -n 's/^MemAvailable: *\([0-9]*\) kB/\1/p' /proc/meminfo 2>/dev/null || true)"
    by_memory=$((${memory_kb:-4000000} / 2000000))
    ((by_memory >= 1)) || by_memory=1
    printf '%s\n' "$((cores < by_memory ? cores : by_memory))"
}

# clang++ needs two thirds of g++'s time. A folder that another compiler has built in keeps it.
choose_compiler() {
    if [[ -z "${CXX:-}" && ! -f "$build/CMakeCache.txt" ]] && command -v clang++-19 >/dev/null; then
        export CXX=clang++-19
    fi
}

build_targets() {
    # Where the packages of the client for browsers came by hand, nobody has looked for them yet.
    if [[ " $* " == *" web_client "* ]] && ! grep -q '^build web_client:' "$build/build.ninja" 2>/dev/null; then
        configure="web_client"
    fi
    if [[ ! -f "$build/build.ninja" || -n "$configure" ]]; then
        choose_compiler
        say "configuring $build${CXX:+ for $CXX}"
        cmake -S "$root" -B "$build" -G Ninja -DZONED_UNITY=ON >"$build.configure.log" 2>&1 || {
            cat "$build.configure.log" >&2
            fail "cmake failed; the reason stands above"
        }
        rm -f "$build.configure.log"
    fi
    say "building: $*"
    cmake --build "$build" --parallel "$(parallel_jobs)" --target "$@" >&2 || fail "the build failed; the reason stands above"
}

if [[ "${1:-}" == "--help" || $# -eq 0 ]]; then
    cat <<'HELP'
usage: config/prepare.sh TARGET...
Installs missing Debian packages (as root or through sudo) and builds TARGETs ("all" for everything) into build/.
ZONED_BUILD=DIR builds somewhere else. CXX=COMPILER builds by another compiler than clang++-19 (only into a new folder).
HELP
    exit 0
fi
# A few targets need a part of the list.
case " $* " in
    *" all "*) needed=() ;;
    *" web_client "*) needed=(-e '/^# Tests/Q') ;;
    *) needed=(-e '/^# Client for browsers/Q') ;;
esac
install_missing
build_targets "$@"
