"""Histograms of a study."""

from __future__ import annotations

import os

import numpy as np

from ...batch.study.chunks import checksums_told
from ...batch.study.store import open_study
from ...batch.study.summary import is_valid, sizes_of, statuses_of
from ...errors import InputError
from .canvas import new_figure, save_figure

__all__ = ["plot_study"]


def plot_study(path: str | os.PathLike[str], picture: str | os.PathLike[str]) -> None:
    """Histograms of all quantities of a store, as a picture (by its ending: svg, png, pdf).

    Raises:
        InputError: there is no store of a study, or nothing in it is valid.
        MissingExtraError: matplotlib is not installed.
    """
    with checksums_told():
        dataset = open_study(path).load()
    good = [code for code, one in statuses_of(dataset).items() if is_valid(one)]
    valid = np.isin(dataset["status"].values, good)
    names = [name for name in sorted(dataset.data_vars) if name != "status"]
    if not valid.any() or not names:
        raise InputError(f'"{path}" holds no valid row to plot')
    figure = new_figure(6.0, 2.2 * len(names))
    for axes, name in zip(np.atleast_1d(figure.subplots(len(names))), names, strict=True):
        label, sizes = sizes_of(dataset[name])
        axes.hist(sizes[valid], bins=80, color="#4477aa")
        axes.set_xlabel(f"{label} [{dataset[name].attrs.get('units', '1')}]")
        axes.set_ylabel("rows")
    save_figure(figure, picture)
