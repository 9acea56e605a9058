#!/bin/sh
# Refuse to go on where PYTHON imports another core than the one built in this checkout, as it does
# where the package is installed in editable mode: ./core/check_import.sh PYTHON
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root" && PYTHONPATH=. "$1" - "$root/impulsekit" <<'END'
import pathlib
import sys

import impulsekit._core

found, built = pathlib.Path(impulsekit._core.__file__).parent.resolve(), pathlib.Path(sys.argv[1]).resolve()
if found != built:
    sys.exit(f"{sys.executable} imports the core of {found}, not the one built in {built}: "
             "pip uninstall impulsekit, or use a Python in which it is not installed")
END
