"""Files that ship with the project, with bytes changed."""

from __future__ import annotations

from random import Random

__all__ = ["mutated"]

_WORDS = (
    b"nan", b"inf", b"1e999", b"-1", b"0", b"1e308", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"<",
    b"\"", b"'", b"&", b"]]>", b"<!DOCTYPE x>", b"<!--", b"[", b"]]", b"=", b"\n", b"\r", b"{}",
    b"\x1b[31m", b"#", b">", b"../", b"link_1", b"world", b"\xc3\x28", b"\xed\xa0\x80", b"name",
    b"999999999999999999999",
)  # fmt: skip


def mutated(rng: Random, whole: bytes) -> bytes:
    """A file with one to six changes."""
    data = bytearray(whole)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        begin = rng.randrange(len(data) + 1)
        end = min(len(data), begin + rng.choice((1, 1, 2, 4, 8, 40, 200)))
        change = rng.randrange(8)
        if change == 0 and begin < len(data):
            data[begin] ^= 1 << rng.randrange(8)
        elif change == 1 and begin < len(data):
            data[begin] = rng.randrange(256)
        elif change == 2:
            del data[begin:end]
        elif change == 3:
            data[begin:begin] = data[begin:end]
        elif change == 4:
            data[begin:begin] = rng.choice(_WORDS)
        elif change == 5:
            data[begin:end] = rng.choice(_WORDS)
        elif change == 6:
            other = rng.randrange(len(data) + 1)
            data[begin:end] = data[other : other + end - begin]
        else:
            data = _number_changed(rng, data)
    return bytes(data)


def _number_changed(rng: Random, data: bytearray) -> bytearray:
    """One of the numbers of the file becomes another."""
    import re

    found = list(re.finditer(rb"-?\d+\.?\d*(e-?\d+)?", data))
    if not found:
        return data
    match = rng.choice(found)
    number = rng.choice(
        (b"0", b"-1", b"1e-300", b"1e300", b"nan", b"inf", b"1e99", b"-" + match[0])
    )
    return data[: match.start()] + number + data[match.end() :]
