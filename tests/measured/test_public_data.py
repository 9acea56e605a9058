"""Files of public recordings, made here in their formats: what is found, read and told."""

import zipfile

import numpy as np
import pytest

from benchmarks.recorded.__main__ import main
from benchmarks.recorded.tensors import read_tensor
from impulsekit.errors import FileError


def zipped_tensor(path, array, opcode=b"torch\nDoubleStorage\n", shape=None):
    """What torch.save has written since version 1.6, put together from its pickled opcodes."""
    rows, columns = array.shape if shape is None else shape

    def number(value):
        return b"J" + int(value).to_bytes(4, "little", signed=True)

    def text(value):
        return b"X" + len(value).to_bytes(4, "little") + value

    storage = (
        b"("
        + text(b"storage")
        + b"c"
        + opcode
        + text(b"0")
        + text(b"cpu")
        + number(array.size)
        + b"tQ"
    )
    whole = (
        b"\x80\x02ctorch._utils\n_rebuild_tensor_v2\n(" + storage + number(0)
        + number(rows) + number(columns) + b"\x86" + number(columns) + number(1) + b"\x86"
        + b"\x89ccollections\nOrderedDict\n)RtR."
    )  # fmt: skip
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("archive/data.pkl", whole)
        file.writestr("archive/data/0", np.asarray(array, "<f8").tobytes())


def test_a_zipped_tensor_is_read_without_torch(tmp_path):
    array = np.random.default_rng(0).normal(size=(4, 15))
    zipped_tensor(tmp_path / "0.pt", array)
    assert np.array_equal(read_tensor(tmp_path / "0.pt"), array)
    zipped_tensor(tmp_path / "1.pt", array, shape=(9, 15))
    with pytest.raises(FileError, match="numbers are missing"):
        read_tensor(tmp_path / "1.pt")
    zipped_tensor(tmp_path / "2.pt", array, opcode=b"os\nsystem\n")
    with pytest.raises(FileError, match=r"os\.system has no place in a tensor"):
        read_tensor(tmp_path / "2.pt")
    (tmp_path / "3.pt").write_bytes((tmp_path / "0.pt").read_bytes()[:300])
    with pytest.raises(FileError, match="no tensor of doubles"):
        read_tensor(tmp_path / "3.pt")


def test_one_bad_set_of_data_does_not_stop_the_others(tmp_path, capsys):
    (tmp_path / "ellipse_uniform.mat").write_text("nothing")
    (tmp_path / "x_00.npy").write_text("nothing")
    main([str(tmp_path)])
    text = capsys.readouterr().out
    assert "left out: " in text and "no list of planar impacts" in text
    assert "cassie_v2.urdf is missing" in text
