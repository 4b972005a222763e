#!/usr/bin/env bash
# debian_test.sh SOURCE BUILD: the Debian packages from their making to their purge, in a bare Debian 12. Needs root and a network.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
source_dir="$(cd "$1" && pwd)"
build="$(cd "$2" && pwd)"
root="$scratch/root"
((EUID == 0)) || { say "needs root"; exit 3; }
need lintian lintian
need systemd-analyze systemd

say "the packages"
(umask 022 && cd "$build" && cpack -G DEB -B "$scratch/cpack" >"$scratch/cpack.log" 2>&1) || { tail -n 20 "$scratch/cpack.log"; fail cpack; }
package="$(echo "$scratch"/cpack/zoned_*.deb)"
[[ -f "$package" ]] || fail "no package was made"
development="$(echo "$scratch"/cpack/zoned-dev_*.deb)"
[[ -f "$development" ]] || fail "no package for games was made"
# Neither a release of Debian nor a public address of the maintainers is there to be named.
lintian --fail-on error --suppress-tags bad-distribution-in-changes-file,bogus-mail-host,bogus-mail-host-in-debian-changelog "$package" "$development" || fail "lintian finds errors"
if [[ -d "$build" && -w "$build" ]]; then cp "$package" "$development" "$build/"; fi

say "the unit"
systemd-analyze security --offline=yes --threshold=20 "$source_dir/docker/debian/zoned.service" >"$scratch/security" 2>&1 ||
    { tail -n 3 "$scratch/security"; fail "the unit is not hardened enough"; }
tail -n 1 "$scratch/security" >&2

base_system "$root"
mount -t proc proc "$root/proc" && mounted+=("$root/proc")
mount --bind /dev "$root/dev" && mounted+=("$root/dev")
inside() { env -i HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    ${http_proxy:+http_proxy=$http_proxy} ${https_proxy:+https_proxy=$https_proxy} chroot "$root" "$@"; }

say "installation"
cp "$package" "$root/root/zoned.deb"
inside apt-get update -q >"$scratch/apt.log" 2>&1 || { tail -n 5 "$scratch/apt.log"; exit 3; }
inside apt-get install -q -y --no-install-recommends /root/zoned.deb >"$scratch/apt.log" 2>&1 || { tail -n 20 "$scratch/apt.log"; fail "apt-get install"; }
inside getent passwd zoned >/dev/null || fail "the user zoned is missing"
[[ "$(stat -c '%U %a' "$root/var/lib/zoned" | sed "s/UNKNOWN/$(inside id -u zoned)/")" == *" 750" ]] || fail "the state folder is open"
[[ "$(inside stat -c %U /var/lib/zoned)" == zoned ]] || fail "the state folder has another owner"
inside dpkg-query -W -f='${Conffiles}\n' zoned | grep -q /etc/zoned/world.txtpb || fail "the world is no conffile"
inside zoned --version | grep -q zoned || fail "zoned --version"
inside zoned check /etc/zoned/world.txtpb >/dev/null || fail "the world of the service has mistakes"

# start NAME: the unit's own command under its user, with a stand-in for systemd.
start() {
    local command
    command="$(sed -n 's/^ExecStart=//p' "$root/lib/systemd/system/zoned.service" | sed 's/ \$ZONED_ARGUMENTS//')"
    rm -f "$root/run/notify" "$scratch/notify"
    python3 "$source_dir/tests/packaging/notify_listener.py" "$root/run/notify" 120 "$scratch/notify" &
    started+=("$!")
    wait_for 10 test -S "$root/run/notify" || fail "the stand-in for systemd"
    env -i LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin NOTIFY_SOCKET=/run/notify WATCHDOG_USEC=2000000 \
        chroot --userspec="$(inside id -u zoned):$(inside id -g zoned)" "$root" \
        sh -c "cd /var/lib/zoned && exec $command" >"$scratch/$1.out" 2>"$scratch/$1.err" &
    server=$!
    started+=("$server")
    wait_for 60 grep -q '^READY=1' "$scratch/notify" || { cat "$scratch/$1.err"; fail "$1: no READY=1"; }
}
stop() {
    kill -TERM "$server"
    local code=0
    wait "$server" || code=$?
    ((code == 0)) || { tail "$scratch/$1.err"; fail "$1: the server ends with $code"; }
    grep -q '^STOPPING=1' "$scratch/notify" || fail "$1: no STOPPING=1"
    [[ -s "$root/var/lib/zoned/report.json" ]] || fail "$1: no report"
}

say "the service lets in who holds a ticket, and gives signs of life"
start first
if inside client-sim --connect 127.0.0.1:7777 --bots 1 --seconds 1 >/dev/null 2>&1; then fail "a bot without a ticket got in"; fi
sleep 3
(($(grep -c '^WATCHDOG=1' "$scratch/notify") >= 2)) || fail "no signs of life"
inside zoned ctl --state /var/lib/zoned status >/dev/null || fail "zoned ctl"
stop first
[[ "$(stat -c '%U %a' "$root/etc/zoned/operator.key")" == "root 600" ]] || fail "others read the private key"
inside zoned ticket --key /etc/zoned/operator.key --account ann --right play --out /etc/zoned/ann.ticket >/dev/null
sed -i 's/^  grace_s: 30/  grace_s: 31/' "$root/etc/zoned/world.txtpb"
cp "$root/etc/zoned/operator.key" "$scratch/key"
start second
inside client-sim --connect 127.0.0.1:7777 --bots 1 --seconds 2 --no-audit --no-freeze --ticket /etc/zoned/ann.ticket >"$scratch/bot" 2>&1 || { cat "$scratch/bot"; fail "a bot with a ticket"; }
stop second

say "a game of one's own, built by its user with what the packages brought"
cp "$development" "$root/root/zoned-dev.deb"
inside apt-get install -q -y --no-install-recommends /root/zoned-dev.deb >"$scratch/apt.log" 2>&1 || { tail -n 20 "$scratch/apt.log"; fail "apt-get install of zoned-dev"; }
inside useradd --create-home ann
declare -A game=([my_game]="" [my_lua]="--lua" [my_match]="--game capture_the_flag")
for name in "${!game[@]}"; do
    measured "zoned new $name ${game[$name]}, until it runs" inside su ann -c \
        "cd && zoned new $name ${game[$name]} --test && $name/run.sh --seconds 1 --set network.tcp_port=0 --set network.udp_port=0"
    grep -q '^ready ' "$scratch/measured.log" || { tail -n 30 "$scratch/measured.log"; fail "$name does not run"; }
    inside su ann -c "cd && $name/package.sh" >"$scratch/game.log" 2>&1 || { tail -n 30 "$scratch/game.log"; fail "the package of $name"; }
done
inside apt-get purge -q -y zoned-dev >/dev/null 2>&1 || fail "the purge of zoned-dev"

say "the games' own packages, where nothing is left to build them"
for name in "${!game[@]}"; do
    inside sh -c "apt-get install -q -y --no-install-recommends /home/ann/$name/build/*.deb" >"$scratch/apt.log" 2>&1 ||
        { tail -n 20 "$scratch/apt.log"; fail "apt-get install of $name"; }
    command="/usr/bin/$name-server"
    [[ -e "$root$command" ]] || command="zoned"  # rules in Lua are files of the server
    inside su ann -c "cd && $command serve --config /usr/share/$name/world.txtpb --set network.tcp_port=0 \
        --set network.udp_port=0 --set 'session.state_folder=\"/home/ann/state-$name\"' --seconds 15 >ready-$name" 2>"$scratch/game.log" &
    started+=("$!")
    wait_for 30 grep -q '^ready ' "$root/home/ann/ready-$name" || { cat "$scratch/game.log"; fail "the packaged $name does not start"; }
    port="$(sed -n 's/^ready tcp=\([0-9]*\).*/\1/p' "$root/home/ann/ready-$name")"
    inside client-sim --connect "127.0.0.1:$port" --bots 5 --seconds 3 >"$scratch/bots" 2>&1 || { cat "$scratch/bots"; fail "bots in the packaged $name"; }
    wait "$!" || { cat "$scratch/game.log"; fail "the packaged $name ends with $?"; }
    inside apt-get purge -q -y "${name//_/-}" >/dev/null 2>&1 || fail "the purge of $name"
done

say "an upgrade keeps what the operator changed"
next="$scratch/next"
dpkg-deb -R "$package" "$next"
sed -i 's/^Version: .*/&.1/' "$next/DEBIAN/control"
echo "# a newer default" >>"$next/etc/zoned/world.txtpb"
(cd "$next" && find . -path ./DEBIAN -prune -o -type f -printf '%P\0' | xargs -0 md5sum >DEBIAN/md5sums)
dpkg-deb --root-owner-group -b "$next" "$root/root/next.deb" >/dev/null
inside sh -c 'date +%s >/var/lib/zoned/of_the_operator'
inside apt-get install -q -y -o Dpkg::Options::=--force-confold /root/next.deb >"$scratch/apt.log" 2>&1 || { tail -n 20 "$scratch/apt.log"; fail "the upgrade"; }
cmp -s "$root/etc/zoned/operator.key" "$scratch/key" || fail "the upgrade made another key"
grep -q '^  grace_s: 31' "$root/etc/zoned/world.txtpb" || fail "the upgrade took the operator's settings"
[[ -f "$root/etc/zoned/world.txtpb.dpkg-dist" ]] || fail "the new default is not offered"
[[ -f "$root/var/lib/zoned/of_the_operator" ]] || fail "the upgrade took the state"
start third
stop third

say "removal keeps settings and state, purge takes them"
inside apt-get remove -q -y zoned >/dev/null 2>&1 || fail "the removal"
[[ ! -e "$root/usr/bin/zoned" && -f "$root/etc/zoned/world.txtpb" && -f "$root/var/lib/zoned/of_the_operator" ]] || fail "the removal"
inside apt-get install -q -y -o Dpkg::Options::=--force-confold /root/zoned.deb >"$scratch/apt.log" 2>&1 ||
    { tail -n 20 "$scratch/apt.log"; fail "the installation after a removal"; }
inside apt-get purge -q -y zoned >/dev/null 2>&1 || fail "the purge"
left="$(find "$root/etc/zoned" "$root/var/lib/zoned" "$root/usr/share/zoned" "$root/etc/default/zoned" 2>/dev/null || true)"
[[ -z "$left" ]] || fail "the purge leaves $left"
if inside getent passwd zoned >/dev/null; then fail "the purge leaves the user"; fi
say "the packages are made, installed, started, used for a game, upgraded, removed and purged"
