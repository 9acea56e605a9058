#!/bin/sh
# Rebuild the core in a checkout, after a change of its sources: ./core/build.sh [PYTHON] [cmake options]
set -e
here=$(cd "$(dirname "$0")" && pwd)
python=${1:-python3}
[ $# -gt 0 ] && shift
# Here warnings are errors; a user's compiler may warn of what it likes.
cmake -S "$here" -B "$here/../build/core" -DPython_EXECUTABLE="$(command -v "$python")" \
    -DCMAKE_COMPILE_WARNING_AS_ERROR=ON "$@" >/dev/null
cmake --build "$here/../build/core" -j 2
sh "$here/check_import.sh" "$python"
