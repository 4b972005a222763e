#!/usr/bin/env bash
# Plays the game with bots, asks for their verdict, and plays the recording again: each tick has to come to the same state.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
scratch="$(mktemp -d)"
server=""
clean_up() {
    if [[ -n "$server" ]]; then kill "$server" 2>/dev/null || true; fi
    rm -rf "$scratch"
}
trap clean_up EXIT

zoned check world.txtpb
zoned serve --config world.txtpb --set network.tcp_port=0 --set network.admin=false \
    --set "session.state_folder=\"$scratch/state\"" --set "recording.file=\"$scratch/test.zrec\"" >"$scratch/ready" 2>"$scratch/log" &
server=$!
until grep -q '^ready ' "$scratch/ready"; do
    kill -0 "$server" 2>/dev/null || { cat "$scratch/log"; exit 1; }
    sleep 0.1
done
port="$(sed -n 's/^ready tcp=\([0-9]*\).*/\1/p' "$scratch/ready")"

# A bad network: a twentieth of the datagrams is lost, the rest comes after 60 ms, give or take 20.
client-sim --connect "127.0.0.1:$port" --bots 10 --seconds 8 --behaviour crowd --loss 5 --delay-ms 60 --jitter-ms 20
kill -TERM "$server"
wait "$server"
server=""
if grep -q 'error in' "$scratch/log"; then
    cat "$scratch/log"
    exit 1
fi
cp world.txtpb game.lua "$scratch/"
zoned replay "$scratch/test.zrec" --threads 2
echo "test: passed"
