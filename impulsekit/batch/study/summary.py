"""The summary of a study: how many rows are good, quantiles, and the worst rows."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import InputError
from ...errors.calls import public
from ...impact.status import Status
from ...motion.record.status import MotionStatus
from .store import UNWRITTEN, StudyStore, open_study

QUANTILES = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)


@dataclass(frozen=True)
class QuantityLine:
    """One quantity over all valid rows.

    Attributes:
        name: an output, of several numbers a row its norm, such as "|dv|".
        quantiles: by ``QUANTILES``.
        worst: the rows with the largest size, the largest first.
    """

    name: str
    quantiles: tuple[float, ...]
    worst: tuple[int, ...]


@public
@dataclass(frozen=True)
class StudySummary:
    """The summary of a study.

    Attributes:
        rows: number of rows of the study.
        statuses: number of written rows by status.
        quantities: quantiles and worst rows of each quantity.

    Example:
        >>> StudySummary(100, {Status.SOLVED: 40}, ()).complete
        False
    """

    rows: int
    statuses: dict[Status | MotionStatus, int]
    quantities: tuple[QuantityLine, ...]

    @property
    def written(self) -> int:
        """The number of rows that are written; fewer than ``rows`` while a study is not done."""
        return sum(self.statuses.values())

    @property
    def complete(self) -> bool:
        """Return whether every row is written."""
        return self.written == self.rows

    @property
    def valid(self) -> bool:
        """Return whether every row is written and may be used."""
        return self.complete and all(map(is_valid, self.statuses))

    def __str__(self) -> str:
        lines = [f"{self.rows} rows"]
        if not self.complete:
            lines = [
                f"not complete: {self.written} of {self.rows} rows are written; run the study "
                "again to go on"
            ]
        for status, count in self.statuses.items():
            lines.append(f"  {count:>10d}  {status.name}")
        head = "".join(f"{f'{100 * p:g} %':>12s}" for p in QUANTILES)
        lines.append(f"{'':24s}{head}   worst rows")
        for one in self.quantities:
            numbers = "".join(f"{x:12.4g}" for x in one.quantiles)
            rows = ", ".join(map(str, one.worst))
            lines.append(f"{one.name:24s}{numbers}   {rows}")
        return "\n".join(lines)


@public
def summarize(store: Any, *, worst: int = 3) -> StudySummary:
    """Compute quantiles and worst rows of a study, with one number per row in memory.

    Rows that are not written yet are only counted.

    Args:
        store: its folder, the ``StudyStore`` of ``run_study``, or the result of ``open_study``.
        worst: number of worst rows reported for each quantity.

    Raises:
        InputError: the folder is not a store of a study, or was damaged.
        MissingExtraError: xarray or dask is not installed.

    Example:
        >>> import dataclasses, tempfile
        >>> from impulsekit.study import load_study, run_study
        >>> study = dataclasses.replace(load_study("examples/landing_study.toml"), samples=100)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     summary = summarize(run_study(study, folder + "/rows"), worst=1)
        >>> summary.rows, len(summary.quantities[0].worst)
        (100, 1)
    """
    dataset = _opened(store)
    status = dataset["status"].values
    codes, counts = np.unique(status[status != UNWRITTEN], return_counts=True)
    statuses = statuses_of(dataset)
    valid = np.isin(status, [code for code, one in statuses.items() if is_valid(one)])
    lines = []
    for name in sorted(dataset.data_vars):
        if name == "status" or not valid.any():
            continue
        label, sizes = sizes_of(dataset[name])
        sizes = np.where(valid, sizes, np.nan)
        quantiles = tuple(float(x) for x in np.nanquantile(sizes, QUANTILES))
        order = np.argsort(-np.nan_to_num(np.abs(sizes), nan=-1.0), kind="stable")
        lines.append(QuantityLine(label, quantiles, tuple(order[:worst].tolist())))
    found = {statuses[int(c)]: int(n) for c, n in zip(codes, counts, strict=True)}
    return StudySummary(len(status), found, tuple(lines))


def statuses_of(dataset: Any) -> dict[int, Status | MotionStatus]:
    """Return the statuses by code: of motions where the rows are motions."""
    names = json.loads(dataset.attrs.get("status", "{}"))
    kind: Any = MotionStatus if MotionStatus.FINISHED.name in names else Status
    return {one.code: one for one in kind}


def is_valid(status: Status | MotionStatus) -> bool:
    """Return whether a row with this status may be used."""
    return status.finished if isinstance(status, MotionStatus) else status.valid


def _opened(store: Any) -> Any:
    """Open the rows of whatever names a store.

    Raises:
        InputError: nothing of a study.
    """
    if isinstance(store, StudyStore):
        return open_study(store.path)
    if not hasattr(store, "data_vars"):
        return open_study(store)
    if "status" not in store.data_vars or store["status"].dtype.kind not in "iu":
        raise InputError("summarize takes the rows of a study, as open_study gives them")
    return store


def sizes_of(variable: Any) -> tuple[str, np.ndarray]:
    """Return a label and one number a row: the number itself, or the norm of several."""
    name = str(variable.name)
    if variable.ndim == 1:
        return name, variable.values
    return f"|{name}|", np.sqrt((variable**2).sum(variable.dims[1:], skipna=False)).values
