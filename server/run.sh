#!/usr/bin/env bash
# The main job: a server on a world, bots that play in it, and a verdict on consistency.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
bots="${BOTS:-200}"
seconds="$(printenv SECONDS || echo 30)" # not $SECONDS: the shell counts in it when nobody has set it
config="${CONFIG:-$root/config/valley.txtpb}"
build="${ZONED_BUILD:-$root/build}"
ready_timeout_s="${READY_TIMEOUT_S:-60}"
stop_timeout_s="${STOP_TIMEOUT_S:-20}"
look_s=604800 # with --open: a week

usage() {
    cat <<'HELP'
usage: server/run.sh [--bots N] [--seconds S] [--config FILE] [--open] [-- CLIENT-SIM-OPTION...]
Installs what is missing, builds, starts a server on FILE (config/valley.txtpb), lets N bots (200) play for S seconds (30)
and prints a verdict. Exit code: 0 consistent, 1 inconsistent, 2 bad usage or config, 3 the environment.
With --open the world runs for looking and playing, with the bots in it, until Ctrl-C: its address is printed, and opened where
a desktop has a browser. Then there is no verdict, and the exit code is 0. The first time it also builds the client for browsers;
once that is there, every run says where to play.
Also from the environment: BOTS, SECONDS, CONFIG, ZONED_BUILD. Options after -- go to client-sim, such as --loss 5.
HELP
}

say() { printf '%s\n' "run: $*" >&2; }

is_number() { [[ "$1" =~ ^[1-9][0-9]*$ ]]; }

open=""
client_options=()
# All bots are wanted in, however busy the machine is that they share with the server. A person may play among them: browsers come
# in by a port of this machine alone (network.websocket_address), as the bots do.
server_options=(--set network.max_load=1000 --set network.websocket_port=0)
while (($# > 0)); do
    case "$1" in
        --help | -h) usage; exit 0 ;;
        --bots | --seconds | --config)
            (($# >= 2)) || { say "$1 needs a value"; exit 2; }
            case "$1" in
                --bots) bots="$2" ;;
                --seconds) seconds="$2" ;;
                --config) config="$2" ;;
            esac
            shift 2 ;;
        --open) open=1; shift ;;
        --) shift; client_options=("$@"); break ;;
        *) say "unknown option '$1'"; usage >&2; exit 2 ;;
    esac
done
is_number "$bots" || { say "--bots needs a positive number, got '$bots'"; exit 2; }
is_number "$seconds" || { say "--seconds needs a positive number, got '$seconds'"; exit 2; }
[[ -r "$config" ]] || { say "cannot read the config '$config'"; exit 2; }

# For looking the client for browsers is built as well; the measured run does not wait for it.
"$root/config/prepare.sh" zoned client-sim ${open:+web_client}

run="$build/run"
mkdir -p "$run"
server_pid=""
client_pid=""

# Waits until a process is gone: 0, or 1 when the seconds are over.
gone_within() {
    local pid="$1" tenths=$(($2 * 10))
    while kill -0 "$pid" 2>/dev/null; do
        ((tenths-- > 0)) || return 1
        sleep 0.1
    done
}

# shellcheck disable=SC2317 # called by the traps
stop_children() {
    local pid
    trap - EXIT INT TERM
    for pid in $client_pid $server_pid; do
        if kill -TERM "$pid" 2>/dev/null && ! gone_within "$pid" 5; then
            kill -KILL "$pid" 2>/dev/null || true
        fi
    done
}
trap stop_children EXIT
trap 'stop_children; exit 130' INT
trap 'stop_children; exit 143' TERM

say "starting the server on $config (log: $run/server.log)"
rm -f "$run/server.json" "$run/client.json" "$run/ready"
"$build/zoned" serve --config "$config" --set "session.state_folder=\"$run\"" --report "$run/server.json" \
    ${server_options[@]+"${server_options[@]}"} >"$run/ready" 2>"$run/server.log" &
server_pid=$!

ready=""
for ((tenths = 0; tenths < ready_timeout_s * 10; ++tenths)); do
    ready="$(grep -m1 '^ready ' "$run/ready" || true)"
    [[ -z "$ready" ]] || break
    kill -0 "$server_pid" 2>/dev/null || break
    sleep 0.1
done
if [[ -z "$ready" ]]; then
    if kill -0 "$server_pid" 2>/dev/null; then
        say "the server was not ready within $ready_timeout_s s; its log ends with:"
        code=3
    else
        code=0
        wait "$server_pid" || code=$?
        server_pid=""
        say "the server ended with exit code $code before it was ready; its log ends with:"
        ((code != 0)) || code=3
    fi
    tail -n 20 "$run/server.log" >&2
    exit "$code"
fi
say "$ready"
port="$(sed -n 's/.* tcp=\([0-9]*\).*/\1/p' <<<"$ready")"
[[ -n "$port" ]] || { say "the ready line names no tcp port"; exit 3; }

admin="$(sed -n 's/.* admin=\([0-9]*\).*/\1/p' <<<"$ready")"
if [[ -r "$run/admin.token" ]]; then
    address="http://127.0.0.1:$admin/#token=$(<"$run/admin.token")"
    say "look at the world: $address"
fi
if [[ -s "$build/web/zoned_client.wasm" ]]; then
    say "play in it: http://127.0.0.1:$admin/play"
fi

if [[ -n "$open" ]]; then
    trap 'stop_children; exit 0' INT
    if [[ -n "${address:-}" && -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]] && command -v xdg-open >/dev/null; then
        xdg-open "$address" >/dev/null 2>&1 || true
    fi
    say "$bots bots play until Ctrl-C"
    "$build/client-sim" --connect "127.0.0.1:$port" --bots "$bots" --seconds "$look_s" --no-audit --no-freeze \
        ${client_options[@]+"${client_options[@]}"} >"$run/client.log" 2>&1 &
    client_pid=$!
    # Whichever ends first ends the rest: a server that stops, or the bots after $look_s seconds.
    wait -n "$client_pid" "$server_pid" || true
    kill -0 "$server_pid" 2>/dev/null || { say "the server stopped; its log ends with:"; tail -n 20 "$run/server.log" >&2; exit 3; }
    exit 0
fi

say "$bots bots play for $seconds s"
verdict=0
"$build/client-sim" --connect "127.0.0.1:$port" --bots "$bots" --seconds "$seconds" --report "$run/client.json" \
    ${client_options[@]+"${client_options[@]}"} &
client_pid=$!
wait "$client_pid" || verdict=$?
client_pid=""

kill -TERM "$server_pid" 2>/dev/null || true
if ! gone_within "$server_pid" "$stop_timeout_s"; then
    say "the server did not stop within $stop_timeout_s s after SIGTERM; its log ends with:"
    tail -n 20 "$run/server.log" >&2
    exit 3
fi
server_code=0
wait "$server_pid" || server_code=$?
server_pid=""
if ((server_code != 0)); then
    say "the server ended with exit code $server_code; its log ends with:"
    tail -n 20 "$run/server.log" >&2
    ((verdict != 0)) || verdict="$server_code"
fi
say "reports: $run/server.json $run/client.json"
exit "$verdict"
