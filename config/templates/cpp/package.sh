#!/usr/bin/env bash
# Makes the game's Debian package in build/. It needs the package zoned where it is installed, and zoned-dev only here.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
cmake --preset game >/dev/null
cmake --build --preset game
cd build
exec cpack -G DEB
