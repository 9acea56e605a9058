"""Files of users: read where they are plain files, written atomically.

A file is written beside its place under a name of its own and renamed into place once all of
it is on the disk. Whatever goes wrong on the way, a full disk, an interrupt, a kill, the file
that stood there stays as it was.
"""

from __future__ import annotations

import contextlib
import math
import os
import pathlib
import stat
from collections.abc import Iterator
from typing import TYPE_CHECKING, BinaryIO

from .errors import FileError, InputError, a_thing, quoted, shown

if TYPE_CHECKING:
    import zipfile

    import numpy as np

_REASONS: dict[type[OSError], str] = {
    FileNotFoundError: "no such file",
    NotADirectoryError: "no such file",
    IsADirectoryError: "that is a folder, not a file",
    PermissionError: "that is not permitted",
}
_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)
# Of files that describe robots and scenes [bytes]; one of a robot with 10 000 links has 10 MB.
LARGEST_TEXT = 100_000_000
# Endings of what is written, by kind.
ENDINGS = {
    "page": (".html", ".htm"),
    "motion": (".npz",),
    "video": (".mp4",),
    "picture": (".png",),
    "scene": (".toml",),
}
# Deflate packs at most so many bytes into one.
MOST_PACKED = 1032
# Characters of a file's name that its temporary name keeps: names end at 255 bytes.
_KEPT_OF_NAME = 40


def reason_of(error: OSError | ValueError) -> str:
    """Return why a file cannot be read or written, in words."""
    if isinstance(error, UnicodeDecodeError):
        return "the file is not UTF-8 text"
    if isinstance(error, ValueError):
        return "a path has no NUL character in it"
    return _REASONS.get(type(error)) or error.strerror or str(error)


@contextlib.contextmanager
def as_file_error(path: str | os.PathLike[str], *, writing: bool = False) -> Iterator[None]:
    """Turn an ``OSError`` on a path into a ``FileError``.

    Raises:
        FileError: what is within raised an ``OSError``, or the path cannot be one.
    """
    try:
        yield
    except FileError:
        raise
    except OSError as error:
        reason = reason_of(error)
        if writing and isinstance(error, FileNotFoundError | NotADirectoryError):
            reason = "there is no folder to write it into"
        wrapped = FileError(f"{shown(os.fspath(path), 200)}: {reason}", path=os.fspath(path))
        wrapped.errno = error.errno
        raise wrapped from error


def path_of(path: object, what: str) -> str:
    """Return the path of a file, in text.

    Raises:
        InputError: it is neither text nor a path.
    """
    text = os.fspath(path) if isinstance(path, str | os.PathLike) else None
    if not isinstance(text, str):
        raise InputError(f"{what} is given by its path, got {a_thing(path)}")
    return text


def open_plain_file(path: str | os.PathLike[str]) -> BinaryIO:
    """Open a file for reading; a pipe might never answer, and a device never end.

    Raises:
        OSError: it is no plain file, or cannot be read.
    """
    _refuse_special(os.stat(path).st_mode)
    # Without waiting, should a pipe have taken its place meanwhile.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    try:
        _refuse_special(os.fstat(descriptor).st_mode)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def read_text_file(path: str | os.PathLike[str]) -> bytes:
    """Return the content of a file that describes a robot or a scene.

    Raises:
        OSError: it is no plain file, cannot be read, or is larger than any such file.
    """
    with open_plain_file(path) as file:
        content = file.read(LARGEST_TEXT + 1)
    if len(content) > LARGEST_TEXT:
        raise OSError(None, f"it is larger than {LARGEST_TEXT // 1_000_000} MB")
    return content


def read_npz(stream: BinaryIO) -> dict[str, np.ndarray]:
    """Return the arrays of an npz file; no more memory is taken than the file can fill.

    Raises:
        ValueError: it is no npz file of plain arrays, is damaged, promises more than it holds, or
            does not fit into memory; the sentence says which.
    """
    import zipfile

    size = stream.seek(0, os.SEEK_END)
    if not zipfile.is_zipfile(stream):
        raise ValueError("it is no npz file")
    try:
        with zipfile.ZipFile(stream) as archive:
            members = archive.infolist()
            promised = sum(member.file_size for member in members)
            if promised > MOST_PACKED * size:
                raise ValueError(f"it promises {promised / 1e9:.3g} GB and cannot hold them")
            if promised > free_memory():
                raise ValueError(f"it needs {promised / 1e9:.3g} GB of memory, which is not free")
            return {one.filename.removesuffix(".npy"): _array(archive, one) for one in members}
    except ValueError:
        raise
    # What zipfile, zlib and numpy raise on a damaged file: CRC, header, encoding, end of file.
    except Exception as error:
        raise ValueError(str(error)) from error


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> np.ndarray:
    """An array of an npz file, whose header is compared with the bytes that follow it."""
    from numpy.lib import format as form

    with archive.open(member) as file:
        old = form.read_magic(file) == (1, 0)
        header = form.read_array_header_1_0 if old else form.read_array_header_2_0
        shape, _, dtype = header(file)
        promised, held = math.prod(shape) * dtype.itemsize, member.file_size - file.tell()
        if promised != held and not dtype.hasobject:
            raise ValueError(f'"{member.filename}" promises {promised} bytes and holds {held}')
    with archive.open(member) as file:
        return form.read_array(file, allow_pickle=False)


def free_memory() -> float:
    """Return how many bytes are free, or can be made so; infinite where nothing tells."""
    try:
        for line in pathlib.Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024.0 * float(line.split()[1])
    except (OSError, ValueError, IndexError):
        pass
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")


def _refuse_special(mode: int) -> None:
    for is_kind, kind in _KINDS:
        if is_kind(mode):
            raise OSError(None, f"that is {kind}, not a file")


def check_writable(path: str | os.PathLike[str]) -> None:
    """Check that a file can be written, as far as that is known without writing it.

    Raises:
        FileError: it is a folder, a pipe or a device, its folder does not exist, or writing is
            not permitted.
    """
    with as_file_error(path, writing=True):
        _check_target(_target(path))


def checked_output(path: object, what: str, *endings: str) -> str:
    """Return the path of a file that can be written, and ends as its content asks for.

    Raises:
        InputError: it is no path, or ends otherwise; files of other formats are not written.
        FileError: it cannot be written.
    """
    text = path_of(path, what)
    if not text.lower().endswith(endings):
        raise InputError(f"{what} must end in {' or '.join(endings)}, got {quoted(text, 200)}")
    check_writable(text)
    return text


def write_file(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Write a whole file, or leave what is there; text as UTF-8.

    Raises:
        FileError: it cannot be written.
    """
    with replaced_file(path) as file:
        file.write(content.encode("utf-8") if isinstance(content, str) else content)


@contextlib.contextmanager
def replaced_file(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Yield a file to write to, which takes the place of ``path`` if nothing is raised.

    What a symbolic link leads to is replaced, and the link stays.

    Raises:
        FileError: it cannot be written; what was there stays as it was.
    """
    with as_file_error(path, writing=True):
        target = _target(path)
        mode = _check_target(target)
        folder, name = os.path.split(target)
        temporary = os.path.join(folder, f".{name[:_KEPT_OF_NAME]}.{os.urandom(8).hex()}.partial")
        descriptor = os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        try:
            with os.fdopen(descriptor, "w+b") as file:
                if mode is not None:
                    os.fchmod(file.fileno(), stat.S_IMODE(mode))
                yield file
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, target)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise


def _target(path: str | os.PathLike[str]) -> str:
    """The file that is written: where symbolic links lead."""
    try:
        return os.path.realpath(os.fspath(path))
    except ValueError:
        raise OSError(None, "a path has no NUL character in it") from None


def _check_target(target: str) -> int | None:
    """The mode of a file that is there and may be replaced; None where there is none."""
    mode = None
    with contextlib.suppress(FileNotFoundError):
        mode = os.stat(target).st_mode
    if mode is not None:
        _refuse_special(mode)
        if not os.access(target, os.W_OK):
            raise PermissionError
    folder = os.path.dirname(target)
    if not os.path.isdir(folder):
        raise FileNotFoundError
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError
    return mode
