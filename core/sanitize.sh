#!/bin/sh
# Run tests with a core that watches its memory and arithmetic (AddressSanitizer,
# UndefinedBehaviorSanitizer): ./core/sanitize.sh PYTHON [pytest arguments]. Rebuild afterwards.
set -e
here=$(cd "$(dirname "$0")" && pwd)
python=${1:-python3}
[ $# -gt 0 ] && shift
cmake -S "$here" -B "$here/../build/sanitized" -DPython_EXECUTABLE="$(command -v "$python")" \
      -DIMPULSEKIT_SANITIZE=ON >/dev/null
cmake --build "$here/../build/sanitized" -j 2
libraries=$(for name in asan ubsan stdc++; do "${CXX:-g++}" -print-file-name=lib$name.so; done)
cd "$here/.."
# Python itself frees little at its end: leaks are not looked for.
export ASAN_OPTIONS=detect_leaks=0:abort_on_error=1 UBSAN_OPTIONS=halt_on_error=1 PYTHONPATH=.
LD_PRELOAD=$(echo $libraries | tr ' ' ':')
export LD_PRELOAD
sh core/check_import.sh "$python"
exec "$python" -m pytest -o addopts="" -p no:cacheprovider -q "$@"
