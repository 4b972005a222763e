# Shared by the packaging tests: steps with a name, a scratch folder that goes, a base system, a server that is waited for.
set -euo pipefail

say() { printf '%s\n' "packaging: $*" >&2; }
fail() { say "FAILED: $*"; exit 1; }
# need PROGRAM PACKAGE: exit 3 where the machine lacks something.
need() { command -v "$1" >/dev/null || { say "needs $1: apt-get install $2"; exit 3; }; }

scratch="$(mktemp -d "${TMPDIR:-/var/tmp}/zoned-packaging.XXXXXX")"
declare -a mounted=() started=()
clean_up() {
    local at
    for at in "${started[@]}"; do kill "$at" 2>/dev/null || true; done
    for ((at = ${#mounted[@]} - 1; at >= 0; --at)); do umount -l "${mounted[at]}" 2>/dev/null || true; done
    if [[ -n "${KEEP:-}" ]]; then say "kept $scratch"; else rm -rf --one-file-system "$scratch"; fi
}
trap clean_up EXIT

# wait_for SECONDS COMMAND...: until the command succeeds.
wait_for() {
    local end=$((SECONDS + $1))
    shift
    until "$@" >/dev/null 2>&1; do
        ((SECONDS < end)) || return 1
        sleep 0.1
    done
}

# measured NAME COMMAND...: prints what the command took, and fails where it took more than 180 s of processors, children and all.
# A game has to run three minutes after its birth. Processor time is what a busy machine does not change; who needs no more of it
# than that has the game within three minutes on a single idle core.
measured() {
    local name="$1" TIMEFORMAT="%R %U %S" wall user system code=0
    shift
    { time "$@" >"$scratch/measured.log" 2>&1 || code=$?; } 2>"$scratch/measured.time"
    ((code == 0)) || { tail -n 40 "$scratch/measured.log"; fail "$name"; }
    read -r wall user system <"$scratch/measured.time"
    say "$name: $wall s, $(awk "BEGIN { print $user + $system }") s of processors"
    awk "BEGIN { exit !($user + $system <= ${MOST_CPU_S:-180}) }" || fail "$name takes more than ${MOST_CPU_S:-180} s of processors"
}

# base_system FOLDER: a bare Debian 12 by debootstrap, or from the tar file ZONED_BASE_TAR where it is set.
base_system() {
    mkdir -p "$1"
    if [[ -n "${ZONED_BASE_TAR:-}" ]]; then
        tar -C "$1" -xf "$ZONED_BASE_TAR"
        mkdir -p "$1"/{dev,proc,sys}
        chmod 755 "$1"  # users have to get in, whatever the tar file says
    else
        need debootstrap debootstrap
        say "debootstrap"
        debootstrap --variant=minbase bookworm "$1" >"$scratch/debootstrap.log" 2>&1 || {
            tail -n 5 "$scratch/debootstrap.log" >&2
            exit 3
        }
    fi
    # The package sources and proxies that work here work inside as well.
    local file
    for file in /etc/apt/sources.list /etc/apt/apt.conf /etc/resolv.conf; do
        if [[ -f $file ]]; then cp "$file" "$1$file"; fi
    done
    cp -r /etc/apt/apt.conf.d/. "$1/etc/apt/apt.conf.d/" 2>/dev/null || true
    cp -r /etc/apt/sources.list.d/. "$1/etc/apt/sources.list.d/" 2>/dev/null || true
}
