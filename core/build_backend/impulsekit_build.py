"""The build backend: scikit-build-core, with a compiler from PyPI where the machine has none."""

from __future__ import annotations

import importlib.util
import os
import shutil
import stat
import sys
import tempfile
from pathlib import Path
from typing import Any

import scikit_build_core.build as backend
from scikit_build_core.build import build_sdist, get_requires_for_build_sdist

__all__ = [
    "build_editable", "build_sdist", "build_wheel", "get_requires_for_build_editable",
    "get_requires_for_build_sdist", "get_requires_for_build_wheel",
]  # fmt: skip

COMPILERS = ("c++", "g++", "clang++")
ZIG = "ziglang>=0.13"


# Where PyPI has wheels of Pinocchio: the newest Python, and no Windows.
NEWEST_PYTHON = (3, 14)


def check_platform() -> None:
    """Say where Pinocchio cannot be installed from PyPI, before pip searches for it in vain."""
    if os.environ.get("CONDA_BUILD") or importlib.util.find_spec("pinocchio"):
        return
    if sys.platform == "win32":
        raise SystemExit(
            "impulsekit needs Pinocchio, which has no wheels for Windows: use WSL, or conda with "
            "Pinocchio from conda-forge (docs/install.md)"
        )
    if sys.version_info[:2] > NEWEST_PYTHON:
        newest = ".".join(map(str, NEWEST_PYTHON))
        raise SystemExit(
            f"impulsekit needs Pinocchio, which has no wheels yet for Python "
            f"{sys.version_info[0]}.{sys.version_info[1]}: use Python 3.11 to {newest}, or conda "
            "with Pinocchio from conda-forge (docs/install.md)"
        )


def has_compiler() -> bool:
    """Return whether a C++ compiler is set or on the path."""
    return bool(os.environ.get("CXX")) or any(map(shutil.which, COMPILERS))


def get_requires_for_build_wheel(settings: Any = None) -> list[str]:
    """Return what building a wheel needs besides pyproject's list."""
    check_platform()
    required: list[str] = backend.get_requires_for_build_wheel(settings)
    return required if has_compiler() else [*required, ZIG]


def get_requires_for_build_editable(settings: Any = None) -> list[str]:
    """Return what an editable install needs besides pyproject's list."""
    check_platform()
    required: list[str] = backend.get_requires_for_build_editable(settings)
    return required if has_compiler() else [*required, ZIG]


def build_wheel(directory: str, settings: Any = None, metadata: str | None = None) -> str:
    """Build a wheel into a directory and return its file name."""
    use_zig_if_needed()
    name: str = backend.build_wheel(directory, settings, metadata)
    return name


def build_editable(directory: str, settings: Any = None, metadata: str | None = None) -> str:
    """Build an editable wheel into a directory and return its file name."""
    use_zig_if_needed()
    name: str = backend.build_editable(directory, settings, metadata)
    return name


def use_zig_if_needed() -> None:
    """Point CMake at the compiler and the archiver of ziglang, where no compiler is found."""
    if has_compiler():
        return
    folder = Path(tempfile.mkdtemp(prefix="impulsekit-zig-"))
    made = {}
    for command in ("cc", "c++", "ar", "ranlib"):
        script = made[command] = folder / command
        # The processor's own instructions would make objects for this machine alone.
        options = " -mcpu=baseline" if command in ("cc", "c++") else ""
        script.write_text(
            f'#!/bin/sh\nexec "{sys.executable}" -m ziglang {command}{options} "$@"\n'
        )
        script.chmod(script.stat().st_mode | stat.S_IXUSR)
    os.environ["CC"], os.environ["CXX"] = str(made["cc"]), str(made["c++"])
    # CMake reads no variables for these.
    tools = f"-DCMAKE_AR={made['ar']} -DCMAKE_RANLIB={made['ranlib']}"
    os.environ["CMAKE_ARGS"] = f"{os.environ.get('CMAKE_ARGS', '')} {tools}".strip()
