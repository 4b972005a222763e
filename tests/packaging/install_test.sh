#!/usr/bin/env bash
# install_test.sh BUILD: cmake --install into an empty prefix; every installed world is checked, and bots play in one.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
build="$1"
prefix="$scratch/prefix"

cmake --install "$build" --prefix "$prefix" >"$scratch/install.log" || { cat "$scratch/install.log"; fail "cmake --install"; }
worlds="$prefix/share/zoned/worlds"
# From another folder: nothing may come from the source tree.
cd "$scratch"
for file in bin/zoned bin/client-sim share/man/man1/zoned.1 share/man/man1/client-sim.1 \
    share/bash-completion/completions/zoned share/doc/zoned/copyright \
    share/doc/zoned/guides/production.md share/zoned/monitoring/alerts.yml; do
    [[ -s "$prefix/$file" ]] || fail "$file is not installed"
done
count=0
for world in "$worlds"/*.txtpb; do
    "$prefix/bin/zoned" check "$world" >"$scratch/check.log" 2>&1 || { cat "$scratch/check.log"; fail "zoned check $world"; }
    count=$((count + 1))
done
((count >= 14)) || fail "only $count worlds are installed"
# The checker is checked: without its geometry a world is no good.
mv "$worlds/geometry" "$worlds/geometry.away"
if "$prefix/bin/zoned" check "$worlds/hills.txtpb" >/dev/null 2>&1; then fail "hills is good without its geometry"; fi
mv "$worlds/geometry.away" "$worlds/geometry"

"$prefix/bin/zoned" serve --config "$worlds/hills.txtpb" --report report.json >ready 2>log &
server=$!
started+=("$server")
wait_for 60 grep -q '^ready ' ready || { cat log; fail "hills does not start"; }
port="$(sed -n 's/^ready tcp=\([0-9]*\).*/\1/p' ready)"
"$prefix/bin/client-sim" --connect "127.0.0.1:$port" --bots 5 --seconds 2 --report client.json >bots 2>&1 ||
    { cat bots; fail "bots in hills"; }
kill -TERM "$server"
wait "$server" || fail "the server ends with $?"
started=()
grep -q '"state_hash"' report.json || fail "no report"
say "installed: $count worlds are good, bots played in hills"
