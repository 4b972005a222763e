#!/usr/bin/env bash
# Builds the game and runs its tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec cmake --workflow --preset test
