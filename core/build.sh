#!/bin/sh
# Rebuild the core in a checkout, after a change of its sources: ./core/build.sh [PYTHON] [cmake options]
set -e
here=$(cd "$(dirname "$0")" && pwd)
python=${1:-python3}
[ $# -gt 0 ] && shift
cmake -S "$here" -B "$here/../build/core" -DPython_EXECUTABLE="$(command -v "$python")" "$@" >/dev/null
cmake --build "$here/../build/core" -j 2
