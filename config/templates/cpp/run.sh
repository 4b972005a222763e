#!/usr/bin/env bash
# Builds the game and runs its server until Ctrl-C. Arguments go to the server, such as --seconds 60.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
cmake --preset game >/dev/null
cmake --build --preset game --target @GAME@-server
exec build/@GAME@-server serve --config world.txtpb "$@"
