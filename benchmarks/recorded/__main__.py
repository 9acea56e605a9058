"""``python -m benchmarks.recorded PATH``: motions and laws beside public recordings in a folder.

Tosses of a cube (ContactNets), of an elbow (dair_pll), planar drops (ImpactModeling) and landings
of Cassie (cassie_impact_dataset); or one file of them.
"""

from __future__ import annotations

import argparse
import sys

from benchmarks.recorded.report import measured_report
from impulsekit.cli.common import bar_on_terminal
from impulsekit.errors import ImpulsekitError


def main(arguments: list[str]) -> int:
    """Write the report to stdout; 2 where there is nothing to be read, and why."""
    parser = argparse.ArgumentParser("python -m benchmarks.recorded", description=__doc__)
    parser.add_argument("path", help="a folder of recordings, or a file")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress")
    chosen = parser.parse_args(arguments)
    bar = tell = None
    if not chosen.quiet:
        bar, tell = bar_on_terminal("steps"), lambda name: sys.stderr.write(f"{name}\n")
    try:
        sys.stdout.write(measured_report(chosen.path, progress=bar, tell=tell))
    except ImpulsekitError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
