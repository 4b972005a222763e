#!/usr/bin/env bash
# install_test.sh BUILD: cmake --install into an empty prefix; every installed world is checked, and bots play in one.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
build="$1"
prefix="$scratch/prefix"

cmake --install "$build" --prefix "$prefix" >"$scratch/install.log" || { cat "$scratch/install.log"; fail "cmake --install"; }
worlds="$prefix/share/zoned/worlds"
# From another folder: nothing may come from the source tree.
cd "$scratch"
for file in bin/zoned bin/client-sim include/zoned_client.h lib/libzoned_client.so.1 share/zoned/client/csharp/ZonedClient.cs share/man/man1/zoned.1 share/man/man1/client-sim.1 \
    share/bash-completion/completions/zoned share/doc/zoned/copyright \
    share/doc/zoned/guides/production.md share/zoned/monitoring/alerts.yml; do
    [[ -s "$prefix/$file" ]] || fail "$file is not installed"
done
# Whoever builds a game has the linker of a compiler, and need not have the one that is used here.
grep -rl --include=*.cmake --include=*.pc -e -fuse-ld "$prefix" >linkers || true
[[ ! -s linkers ]] || fail "$(cat linkers) names a linker"
count=0
for world in "$worlds"/*.txtpb "$worlds"/methods/*.txtpb; do
    "$prefix/bin/zoned" check "$world" >"$scratch/check.log" 2>&1 || { cat "$scratch/check.log"; fail "zoned check $world"; }
    count=$((count + 1))
done
((count >= 25)) || fail "only $count worlds are installed"
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
# A game of one's own, by pkg-config and by CMake, and the Python module, from the prefix alone.
export LD_LIBRARY_PATH="$prefix/lib" PKG_CONFIG_PATH="$prefix/lib/pkgconfig" ZONED_CLIENT_LIBRARY="$prefix/lib/libzoned_client.so.1"
examples="$prefix/share/zoned/client"
# shellcheck disable=SC2046  # several words on purpose
cc -std=c99 -o by_pkg_config "$examples/c/look_around.c" $(pkg-config --cflags --libs zoned_client) || fail "pkg-config"
cat >CMakeLists.txt <<'PROJECT'
cmake_minimum_required(VERSION 3.25)
project(game LANGUAGES C)
find_package(zoned_client REQUIRED)
add_executable(by_cmake ${EXAMPLES}/c/look_around.c)
target_link_libraries(by_cmake PRIVATE zoned_client::zoned_client)
PROJECT
cmake -S . -B game -DCMAKE_PREFIX_PATH="$prefix" -DEXAMPLES="$examples" >cmake.log 2>&1 && cmake --build game >>cmake.log 2>&1 ||
    { cat cmake.log; fail "find_package(zoned_client)"; }
for game in ./by_pkg_config game/by_cmake "python3 $examples/python/look_around.py"; do
    # shellcheck disable=SC2086  # a command and its arguments
    $game 127.0.0.1 "$port" >game.log 2>&1 || { cat game.log; fail "$game"; }
    grep -q '^me, ' game.log || { cat game.log; fail "$game sees nothing"; }
done
kill -TERM "$server"
wait "$server" || fail "the server ends with $?"
started=()
grep -q '"state_hash"' report.json || fail "no report"
# Games of one's own with the tools that come along; nothing is overwritten.
# From nothing to a server that runs and a test that passed: at most three minutes.
new_game() {  # NAME OPTION...
    "$prefix/bin/zoned" new "$@" --test && "$1/run.sh" --seconds 1 --set network.tcp_port=0 --set network.udp_port=0
}
# The guide to first rules makes the plain game, and its test follows it.
for game in "my_lua --lua" "my_match --game capture_the_flag"; do
    # shellcheck disable=SC2086  # several words on purpose
    PATH="$prefix/bin:$PATH" CMAKE_PREFIX_PATH="$prefix" measured "zoned new $game, until it runs" new_game $game
    grep -q '^ready ' "$scratch/measured.log" || { cat "$scratch/measured.log"; fail "$game does not run"; }
    cp "$scratch/measured.log" "${game%% *}.log"
    PATH="$prefix/bin:$PATH" CMAKE_PREFIX_PATH="$prefix" "${game%% *}/package.sh" >game.log 2>&1 || { cat game.log; fail "the package of $game"; }
    dpkg-deb --contents "${game%% *}"/build/*.deb | grep -q world.txtpb || fail "the package of $game holds no world"
done
grep -q 'every hash agrees' my_lua.log || { cat my_lua.log; fail "the new game in Lua was not replayed"; }
# The clock is checked: nothing is made in no time.
if (MOST_CPU_S=0 measured "a clock that finds" "$prefix/bin/zoned" new too_late) >/dev/null 2>&1; then fail "no game takes too long"; fi
# Its bots score on a running server, and the next server has the leaderboard from its store.
start_match() {
    rm -f ready  # the last server's line would do, until this one's shell empties the file
    my_match/build/my_match-server serve --config my_match/world.txtpb --set network.tcp_port=0 --set network.udp_port=0 >ready 2>log &
    server=$!
    started=("$server")
    wait_for 60 grep -q '^ready ' ready || { cat log; fail "capture the flag does not start"; }
    port="$(sed -n 's/^ready tcp=\([0-9]*\).*/\1/p' ready)"
}
play_match() {  # SECONDS BOARD
    my_match/build/my_match-bots --connect "127.0.0.1:$port" --bots 10 --seconds "$1" >game.log 2>&1 || { cat game.log; fail "bots of capture the flag"; }
    sed -n '/^leaderboard:/,$p' game.log >"$2"
}
stop_match() {
    kill -TERM "$server"
    wait "$server" || fail "capture the flag ends with $?"
    started=()
}
start_match
for _ in $(seq 12); do  # they score in half of such matches, but in a tenth of those of 20 s
    play_match 40 board.before
    if grep -q ' bot-' board.before; then break; fi
done
grep -q ' bot-' board.before || { cat game.log; fail "nobody scores"; }
# The bot that hears the board may leave a match before its last goal. This one is too short for a goal, once dropped flags are home.
sleep 11
play_match 1 board.before
stop_match
start_match
play_match 1 board.after
stop_match
diff board.before board.after >&2 || fail "another leaderboard after a restart"
if "$prefix/bin/zoned" new my_match >game.log 2>&1; then fail "a game was overwritten"; fi
# The game's own test is checked: rules with a clock are found.
sed -i 's/#include <stdexcept>/#include <ctime>\n&/; s/return context.now() + /&clock() % 7 + /' my_match/game.cpp
if CMAKE_PREFIX_PATH="$prefix" my_match/test.sh >game.log 2>&1; then fail "rules with a clock pass"; fi
grep -q 'not the same in a second run' game.log || { cat game.log; fail "the test does not name the clock"; }
say "installed: $count worlds are good, bots and games by the client library played in hills, new games pass their tests"
