#!/usr/bin/env bash
# Makes the game's Debian package in build/. It needs the package zoned where it is installed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
name="@GAME@"
package="${name//_/-}"
rm -rf build/package
install -d build/package/DEBIAN "build/package/usr/share/$name"
install -m 644 world.txtpb game.lua "build/package/usr/share/$name/"
cat >build/package/DEBIAN/control <<CONTROL
Package: $package
Version: 0.1.0
Architecture: all
Depends: zoned
Maintainer: the authors of $name <nobody@localhost>
Description: $name, a game on zoned
CONTROL
exec dpkg-deb --root-owner-group --build build/package "build/${package}_0.1.0_all.deb"
