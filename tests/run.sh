#!/usr/bin/env bash
# Installs what is missing, builds everything and runs all tests. Arguments go to ctest, such as -R unit_config.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="${ZONED_BUILD:-$root/build}"

if [[ "${1:-}" == "--help" || "${1:-}" == "-h" ]]; then
    cat <<'HELP'
usage: tests/run.sh [CTEST-OPTION...]
Installs missing Debian packages (as root or through sudo), builds into build/ and runs all tests through ctest.
ZONED_BUILD=DIR builds somewhere else.
HELP
    exit 0
fi
"$root/config/prepare.sh" all
# Three slots a core: tests/CMakeLists.txt says which test takes how many.
log="$(cd "$build" && pwd)/tests.xml"
status=0
ctest --test-dir "$build" --output-on-failure --output-junit "$log" -j$((3 * $(nproc))) "$@" || status=$?
# By now the output of a failed test stands a thousand lines up.
((status == 0)) || [[ ! -f "$log" ]] || python3 "$root/tests/print_failures.py" "$log" >&2
exit "$status"
