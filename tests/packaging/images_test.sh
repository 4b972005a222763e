#!/usr/bin/env bash
# images_test.sh SOURCE BUILD: builds the images of server and bots by buildah, without a daemon, and runs them. Needs root and a
# network. BUILD holds the Debian package (cmake --build BUILD --target package).
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
source_dir="$(cd "$1" && pwd)"
build="$(cd "$2" && pwd)"
((EUID == 0)) || { say "needs root"; exit 3; }
need buildah buildah
export STORAGE_DRIVER=vfs BUILDAH_ISOLATION=chroot
store=(--root "$scratch/store" --runroot "$scratch/run")
image() { buildah "${store[@]}" "$@"; }

mkdir "$scratch/context"
cp "$build"/zoned_*.deb "$scratch/context/" || fail "no package in $build"
base_system "$scratch/base"
tar -C "$scratch/base" --exclude='./dev/*' --exclude='./proc/*' --exclude='./sys/*' -cf "$scratch/base.tar" .
rm -rf --one-file-system "$scratch/base"
say "the base image"
container="$(image from scratch)"
image add -q "$container" "$scratch/base.tar" / >/dev/null
image commit -q "$container" localhost/base >/dev/null
image rm "$container" >/dev/null
rm "$scratch/base.tar"

for target in server bots; do
    say "the image of the $target"
    image build -q --format docker --build-arg BASE=localhost/base --target "$target" -f "$source_dir/docker/Dockerfile" \
        -t "localhost/zoned-$target" "$scratch/context" >"$scratch/build.log" 2>&1 || { tail -n 20 "$scratch/build.log"; fail "the image of the $target"; }
done
# field TEMPLATE: of the server's image.
field() { image inspect --type image --format "$1" localhost/zoned-server; }
[[ "$(field '{{.Docker.Config.User}}')" == zoned ]] || fail "the server runs as root"
field '{{.Docker.Config.Healthcheck}}' | grep -q status || fail "no health check"

# The image's own command: what `docker run zoned` would run.
mapfile -t command < <(field '{{range .Docker.Config.Entrypoint}}{{println .}}{{end}}{{range .Docker.Config.Cmd}}{{println .}}{{end}}' | sed '/^$/d')
say "runs ${command[*]}"
server="$(image from localhost/zoned-server)"
image run "$server" -- "${command[@]}" >"$scratch/out" 2>"$scratch/err" &
started+=("$!")
process=$!
wait_for 60 grep -q '^ready ' "$scratch/out" || { cat "$scratch/err"; fail "the server does not start by default"; }
[[ "$(image run "$server" -- id -un)" == zoned ]] || fail "the container's user"
image run "$server" -- zoned ctl --state /var/lib/zoned status >/dev/null || fail "the health check"
pid="$(pgrep -f -n "^(/usr/bin/)?zoned serve --config /etc/zoned/world.txtpb --report /var/lib/zoned/report.json" || true)"
[[ -n "$pid" ]] || fail "no server process"
kill -TERM "$pid"
code=0
wait "$process" || code=$?
((code == 0)) || { tail "$scratch/err"; fail "the server ends with $code"; }
started=()

say "a world with geometry and bots in their own image"
image run "$server" -- zoned serve --config /usr/share/zoned/worlds/hills.txtpb --set 'session.state_folder="/tmp/state"' \
    --seconds 25 >"$scratch/out" 2>"$scratch/err" &
process=$!
wait_for 60 grep -q '^ready ' "$scratch/out" || { cat "$scratch/err"; fail "hills does not start"; }
port="$(sed -n 's/^ready tcp=\([0-9]*\).*/\1/p' "$scratch/out")"
bots="$(image from localhost/zoned-bots)"
image run "$bots" -- client-sim --connect "127.0.0.1:$port" --bots 5 --seconds 3 >"$scratch/bots" 2>&1 || { cat "$scratch/bots"; fail "bots"; }
code=0
wait "$process" || code=$?
((code == 0)) || fail "the server ends with $code"
for world in $(image run "$server" -- sh -c 'ls /usr/share/zoned/worlds/*.txtpb /usr/share/zoned/worlds/methods/*.txtpb'); do
    image run "$server" -- zoned check "$world" >/dev/null || fail "zoned check $world"
done
image run "$server" -- sh -c '! zoned serve --config /nonexistent 2>/dev/null' || fail "a missing world is no failure"
say "images are built, run by default as a user of their own, and hold what the worlds need"
