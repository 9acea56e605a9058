"""meshcat, loaded when something is drawn and not before."""

from __future__ import annotations

import pathlib
import warnings
from types import ModuleType

from ..errors import MissingExtraError

__all__ = ["meshcat", "packed", "player_script"]


def meshcat() -> ModuleType:
    """The package meshcat with its ``geometry`` and ``commands``.

    No server is started and no port is opened.

    Raises:
        MissingExtraError: it is not installed.
    """
    with warnings.catch_warnings():
        # meshcat 0.3.2 still imports an event loop that pyzmq has given up.
        warnings.filterwarnings("ignore", message=r"zmq\.eventloop\.ioloop", append=False)
        warnings.filterwarnings("ignore", category=SyntaxWarning, module=r"meshcat\.")
        try:
            import meshcat
            import meshcat.commands
            import meshcat.geometry
        except ImportError as error:
            raise MissingExtraError(
                f"a replay needs meshcat: pip install meshcat ({error})",
                package="meshcat",
                extra="",
            ) from None
    return meshcat


def packed(command: dict) -> bytes:
    """A command as meshcat's player reads it."""
    import umsgpack

    return umsgpack.packb(command)


def player_script() -> str:
    """The JavaScript of meshcat's own player, from the installed package.

    Raises:
        MissingExtraError: the package came without it.
    """
    path = pathlib.Path(str(meshcat().__file__)).parent / "viewer" / "dist" / "main.min.js"
    try:
        return path.read_text(encoding="utf-8")
    except OSError:
        raise MissingExtraError(
            f"meshcat came without its player, {path}: pip install --force-reinstall meshcat",
            package="meshcat",
            extra="",
        ) from None
