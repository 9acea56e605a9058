"""Files of recorded tosses: torch's old format is read without torch, and calls nothing."""

import collections
import pickle
import sys
import types

import numpy as np
import pytest

from benchmarks.motions import cube_scene
from benchmarks.recorded.tensors import read_tensor
from benchmarks.recorded.tosses import load_tosses
from impulsekit.errors import FileError


@pytest.fixture
def save(monkeypatch):
    """What torch.save wrote before version 1.6, made by stand-ins for its names."""
    torch, utils = types.ModuleType("torch"), types.ModuleType("torch._utils")

    class DoubleStorage:
        pass

    def _rebuild_tensor_v2(*_):
        pass

    DoubleStorage.__module__, DoubleStorage.__qualname__ = "torch", "DoubleStorage"
    _rebuild_tensor_v2.__module__ = "torch._utils"
    _rebuild_tensor_v2.__qualname__ = "_rebuild_tensor_v2"
    torch.DoubleStorage, utils._rebuild_tensor_v2 = DoubleStorage, _rebuild_tensor_v2
    torch._utils = utils
    monkeypatch.setitem(sys.modules, "torch", torch)
    monkeypatch.setitem(sys.modules, "torch._utils", utils)

    def saved(path, array):
        class Tensor:
            def __reduce__(self):
                strides = tuple(step // 8 for step in array.strides)
                return _rebuild_tensor_v2, (
                    marker, 0, array.shape, strides, False, collections.OrderedDict()
                )  # fmt: skip

        class Pickler(pickle.Pickler):
            def persistent_id(self, thing):
                if thing is marker:
                    return ("storage", DoubleStorage, "1", "cpu", array.size, None)
                return None

        marker = object()
        with path.open("wb") as file:
            for part in (119547037146038801333356, 1001, {"little_endian": True}):
                pickle.dump(part, file, protocol=2)
            Pickler(file, protocol=2).dump(Tensor())
            pickle.dump(["1"], file, protocol=2)
            file.write(array.size.to_bytes(8, "little"))
            file.write(array.tobytes())

    return saved


def test_a_tensor_is_read_without_torch(save, tmp_path):
    array = np.random.default_rng(0).normal(size=(1, 4, 19))
    save(tmp_path / "0.pt", array)
    assert np.array_equal(read_tensor(tmp_path / "0.pt"), array)
    whole = (tmp_path / "0.pt").read_bytes()
    (tmp_path / "1.pt").write_bytes(whole[:-40])
    with pytest.raises(FileError, match="no tensor of doubles"):
        read_tensor(tmp_path / "1.pt")


def test_a_file_that_names_what_is_no_tensor_calls_nothing(tmp_path):
    class Evil:
        def __reduce__(self):
            return sys.exit, (3,)

    (tmp_path / "0.pt").write_bytes(pickle.dumps(Evil(), protocol=2))
    with pytest.raises(FileError, match="has no place in a tensor"):
        read_tensor(tmp_path / "0.pt")


def test_tosses_of_a_folder(save, tmp_path):
    scene = cube_scene()
    state = np.zeros((1, 3, 19))
    state[0, :, 2], state[0, :, 3] = [1.0, 0.9, 0.8], 1.0
    for k in (10, 2):
        save(tmp_path / f"{k}.pt", state)
    tosses = load_tosses(tmp_path, scene.robot)
    assert [toss.name for toss in tosses] == ["toss 2", "toss 10"]
    # The files measure lengths in halves of the cube's side.
    assert tosses[0].q[:, 2] == pytest.approx(0.0524 * np.array([1.0, 0.9, 0.8]))
    assert tosses[0].t[1] == 1 / 148
