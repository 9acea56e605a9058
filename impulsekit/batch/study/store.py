"""The store of a study: a Zarr group, written chunk by chunk through xarray.

A chunk counts once its mark stands in the folder ``done`` beside the arrays; marks are
renamed into place after the data. A run that was killed leaves chunks without marks:
they are drawn and written again, bit for bit as they would have been.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import pathlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from ...errors import ImpulsekitError, InputError, MissingExtraError
from ...laws.status import Status
from .study import Study

__all__ = ["StudyStore", "open_study"]

MARKS = "done"
FORMAT = 1
UNITS = {
    "v_after": "rad/s, m/s",
    "dv": "rad/s, m/s",
    "generalized_impulse": "N m s, N s",
    "energy_change": "J",
    "contact_impulses": "N s",
    "constraint_impulses": "N s, N m s",
    "q": "rad, m",
    "v": "rad/s, m/s",
}


class StudyStore:
    """Where a study's rows go.

    Attributes:
        path: the folder.
        study: the study it belongs to.
    """

    def __init__(self, path: str | os.PathLike[str], study: Study) -> None:
        self.path, self.study = pathlib.Path(path), study

    def prepare(self) -> list[int]:
        """Make the store, or open one of the same study; the chunks that are still to do.

        Raises:
            InputError: the folder holds something else, or the store of another study.
            MissingExtraError: xarray or zarr is not installed.
        """
        mark = self.path / "study.json"
        if mark.exists():
            self._check_same(mark)
        elif self.path.exists() and any(self.path.iterdir()):
            if not (self.path / "unfinished").exists():
                raise InputError(
                    f'"{self.path}" is a folder that holds something else; name one that is '
                    "empty or does not exist"
                )
            self._create(mark)
        else:
            self._create(mark)
        for left in self.path.rglob("*.partial"):
            left.unlink(missing_ok=True)
        done = {int(name.name) for name in (self.path / MARKS).iterdir()}
        return [i for i in range(self.study.chunks) if i not in done]

    def write(self, index: int, arrays: dict[str, np.ndarray]) -> None:
        """Write a chunk, then its mark.

        Raises:
            StoreFullError: no space is left; what is done stays done.
        """
        import xarray as xr

        begin, end = self.study.rows(index)
        shapes = self._layout()
        data = {name: (shapes[name][0], array) for name, array in arrays.items()}
        with _full_disk_told(self.path):
            xr.Dataset(data).to_zarr(
                self.path / "rows.zarr",
                region={"row": slice(begin, end)},
                consolidated=False,
            )
            mark = self.path / MARKS / f"{index:08d}"
            partial = self.path / f"mark-{index:08d}.partial"
            partial.write_text("")
            os.replace(partial, mark)

    def _check_same(self, mark: pathlib.Path) -> None:
        try:
            there = json.loads(mark.read_text())
        except ValueError:
            raise InputError(f'"{mark}" is damaged; it is no store of a study') from None
        if there.get("fingerprint") != self.study.fingerprint:
            ours, theirs = self.study.describe(), there.get("study", {})
            changed = [key for key in ours if ours[key] != theirs.get(key)]
            raise InputError(
                f'"{self.path}" is the store of another study: {", ".join(changed)} differ. '
                "Name another folder, or delete this one"
            )

    def _create(self, mark: pathlib.Path) -> None:
        xr = _xarray()
        (self.path / MARKS).mkdir(parents=True, exist_ok=True)
        (self.path / "unfinished").write_text("")
        import dask.array as da

        study, robot = self.study, self.study.scene.robot
        data = {}
        for name, (dims, shape, dtype, attributes) in self._layout().items():
            chunks = (study.chunk, *shape)
            empty = da.zeros((study.samples, *shape), chunks=chunks, dtype=dtype)
            data[name] = (dims, empty, attributes)
        coordinates = {
            "dof": _dof_names(robot),
            "axis": ["x", "y", "z"],
            "contact": list(study.scene.entry_names("contacts")),
            "link": list(study.scaled_links),
        }
        used = {dim for dims, *_ in data.values() for dim in dims}
        kept = {name: values for name, values in coordinates.items() if name in used}
        dataset = xr.Dataset(
            data,
            coords=kept,
            attrs={
                "title": f"impulsekit study of {robot.name}",
                "study": json.dumps(study.describe(), sort_keys=True),
                "status": json.dumps({code.name: code.code for code in Status}),
            },
        )
        with _full_disk_told(self.path):
            dataset.to_zarr(
                self.path / "rows.zarr",
                mode="w",
                compute=False,
                consolidated=False,
                zarr_format=2,
                # Digits of floats are noise to a compressor.
                encoding={name: {"compressors": None} for name in data},
            )
            record = {
                "format": FORMAT,
                "fingerprint": study.fingerprint,
                "study": study.describe(),
            }
            partial = mark.with_suffix(".partial")
            partial.write_text(json.dumps(record, indent=1, sort_keys=True))
            os.replace(partial, mark)
            (self.path / "unfinished").unlink()

    def _layout(self) -> dict[str, tuple]:
        """By array: dimensions, shape of a row, type, attributes."""
        from ..solve import _shape

        study, robot = self.study, self.study.scene.robot
        dims = {
            "energy_change": (),
            "contact_impulses": ("contact", "axis"),
            "constraint_impulses": ("constraint_row",),
            "q": ("q_entry",),
            "v": ("dof",),
        }
        found: dict[str, tuple] = {
            "status": (("row",), (), np.int8, {"meaning": "see the attribute status"})
        }
        for name in study.outputs:
            own = ("row", *dims.get(name, ("dof",)))
            found[name] = (own, _shape(study.scene, name), float, {"units": UNITS[name]})
        whats = {one.what for one in study.vary}
        if "configuration" in whats:
            found["q"] = (("row", "q_entry"), (robot.nq,), float, {"units": UNITS["q"]})
        if "velocity" in whats:
            found["v"] = (("row", "dof"), (robot.nv,), float, {"units": UNITS["v"]})
        if whats & {"impulse", "direction"}:
            width = sum(
                6 if hasattr(one, "linear") else len(one.impulse) for one in study.scene.impulses
            )
            units = {"units": "N s, N m s", "order": "as in the scene, entry after entry"}
            found["impulses"] = (("row", "impulse_entry"), (width,), float, units)
        count = (len(study.scene.contacts),)
        if "mass" in whats:
            units = {"units": "1", "meaning": "factors on mass and inertia of links"}
            found["masses"] = (("row", "link"), (len(study.scaled_links),), float, units)
        for name in ("restitution", "friction"):
            if name in whats:
                found[name] = (("row", "contact"), count, float, {"units": "1"})
        return found


def open_study(path: str | os.PathLike[str]) -> Any:
    """The rows of a store as an ``xarray.Dataset``, read when they are needed.

    Raises:
        InputError: there is no store of a study.
        MissingExtraError: xarray or zarr is not installed.
    """
    folder = pathlib.Path(path)
    if not (folder / "study.json").exists():
        raise InputError(f'"{folder}" is no store of a study')
    return _xarray().open_zarr(folder / "rows.zarr", consolidated=False)


def _xarray() -> Any:
    try:
        import dask  # noqa: F401
        import xarray
        import zarr  # noqa: F401
    except ImportError as error:
        package = str(error.name).partition(".")[0]
        raise MissingExtraError.of(package, "batch", "the store of a study") from None
    return xarray


def _dof_names(robot: Any) -> list[str]:
    names = []
    for name, joint in zip(list(robot.model.names)[1:], list(robot.model.joints)[1:], strict=True):
        names.extend([name] if joint.nv == 1 else [f"{name}[{k}]" for k in range(joint.nv)])
    return names


@contextlib.contextmanager
def _full_disk_told(path: pathlib.Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            raise StoreFullError(
                f'no space left for "{path}" ({error.strerror}); make room and run the same '
                "command again: what is done stays done",
                path=str(path),
            ) from None
        raise


class StoreFullError(ImpulsekitError):
    """The disk of a store is full. Attributes: path."""

    path: str
