#!/usr/bin/env bash
# Runs the game's server until Ctrl-C. Arguments go to the server, such as --seconds 60.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec zoned serve --config world.txtpb "$@"
