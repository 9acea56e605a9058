"""Compiled code that is kept on disk is never that of older sources."""

import pathlib
import shutil
import subprocess
import sys

import impulsekit


def test_what_was_kept_goes_when_any_file_changes(tmp_path):
    package = pathlib.Path(impulsekit.__file__).parent
    copy = tmp_path / "impulsekit"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))
    run = [sys.executable, "-c", "import impulsekit.batch.kernels"]
    kept = copy / "batch/kernels/__pycache__"
    subprocess.run(run, cwd=tmp_path, check=True)
    (kept / "block.nbc").write_text("compiled")
    subprocess.run(run, cwd=tmp_path, check=True)
    assert (kept / "block.nbc").exists()
    with (copy / "batch/kernels/slip.py").open("a") as source:
        source.write("# changed\n")
    subprocess.run(run, cwd=tmp_path, check=True)
    assert not (kept / "block.nbc").exists()
