"""A Sphinx extension: reference and gallery are made before pages are read; formulas as MathML."""

from __future__ import annotations

import inspect
import os
import re
import time
from pathlib import Path
from types import ModuleType
from typing import Any

from docutils import nodes
from docutils.utils.math import latex2mathml
from make_gallery import write_gallery
from sphinx.util import logging

SAY = logging.getLogger(__name__).info
GENERATED = Path(__file__).parent / "_generated"
# Reference pages: file, title, and the modules whose names belong there, by the longest prefix.
PAGES = (
    ("robot", "Robots", ("robot", "chain", "models")),
    ("scene", "Scenes", ("scene",)),
    ("scenefile", "Scene files", ("scenefile",)),
    ("impact", "Impacts", ("impact", "laws")),
    (
        "derivatives",
        "Derivatives",
        (
            "impact.derivatives",
            "impact.saltation",
            "derivatives",
            "batch.derivatives",
            "torch",
            "jax",
            "casadi",
            "control",
        ),
    ),
    ("motion", "Motion", ("motion",)),
    ("batch", "Batches and long chains", ("batch",)),
    ("study", "Studies", ("batch.study",)),
    ("simulators", "Other simulators and learning", ("batch.problems", "mujoco", "rl")),
    ("design", "Design and fits", ("design",)),
    ("compliance", "Forces of impacts and limits", ("compliance",)),
    ("measured", "Measured motions", ("measured",)),
    ("checking", "Checks", ("checking",)),
    ("view", "Pages, plots and reports", ("view",)),
    ("errors", "Errors", ("errors",)),
)
# Modules whose own public names belong to the reference, besides those of the package.
MODULES = (
    "measured",
    "design",
    "compliance",
    "mujoco",
    "rl",
    "casadi",
    "control",
    "study",
    "long",
    "models",
    "scene",
    "scenefile",
    "impact",
    "impact.derivatives",
    "impact.freed",
    "impact.saltation",
    "motion",
    "checking",
    "view",
    "view.plots",
    "errors",
    "robot",
)


def public_names() -> dict[int, tuple[str, Any]]:
    """Return every public object by its id: the name to call it by, and the object."""
    import importlib

    package = importlib.import_module("impulsekit")
    found: dict[int, tuple[str, Any]] = {}
    for name in package.__all__:
        value = getattr(package, name)
        if not isinstance(value, ModuleType | str):
            found[id(value)] = (f"impulsekit.{name}", value)
    for room in MODULES:
        module = importlib.import_module(f"impulsekit.{room}")
        names = getattr(module, "__all__", None) or [n for n in dir(module) if n[0] != "_"]
        for name in names:
            value = getattr(module, name)
            ours = getattr(value, "__module__", "").startswith("impulsekit")
            if ours and (inspect.isclass(value) or inspect.isroutine(value)):
                found.setdefault(id(value), (f"impulsekit.{room}.{name}", value))
    return found


def page_of(value: Any) -> str:
    """Return the reference page of an object, by the module that it is written in."""
    module = value.__module__.removeprefix("impulsekit.")
    fitting = [
        (len(prefix), page)
        for page, _, prefixes in PAGES
        for prefix in prefixes
        if module == prefix or module.startswith(prefix + ".")
    ]
    return max(fitting)[1]


def write_reference() -> int:
    """Write a page for each name, by autodoc, and one a room that lists them; gives their count."""
    pages: dict[str, list[tuple[str, str]]] = {page: [] for page, _, _ in PAGES}
    for name, value in sorted(public_names().values(), key=lambda entry: entry[0].lower()):
        kind = "autoclass" if inspect.isclass(value) else "autofunction"
        if inspect.isclass(value) and issubclass(value, Exception):
            kind = "autoexception"
        text = f".. {kind}:: {name}\n"
        if kind == "autoclass":
            # A class whose methods stand in several files of its room.
            room = value.__module__.rpartition(".")[0]
            if any(base.__module__.rpartition(".")[0] == room for base in value.__mro__[1:]):
                text += "   :inherited-members:\n"
        page, own = page_of(value), name.removeprefix("impulsekit.")
        pages[page].append((own, first_sentence(value)))
        text = f"# {own}\n\n```{{eval-rst}}\n{text}\n```\n"
        _write(GENERATED / "reference" / page / f"{own}.md", text)
    for page, title, _ in PAGES:
        links = [(f"{{doc}}`{own} <{page}/{own}>`", words) for own, words in pages[page]]
        rows = "\n".join(f"| {link} | {words} |" for link, words in links)
        hidden = "\n".join(f"{page}/{own}" for own, _ in pages[page])
        text = f"# {title}\n\n| name | |\n|---|---|\n{rows}\n\n"
        text += f"```{{toctree}}\n:hidden:\n{hidden}\n```\n"
        _write(GENERATED / "reference" / f"{page}.md", text)
    return sum(map(len, pages.values()))


def first_sentence(value: Any) -> str:
    """Return the first sentence of a docstring as a cell of a table."""
    words = " ".join((inspect.getdoc(value) or "").split("\n\n")[0].split())
    return re.split(r"(?<=[.:])\s", words)[0].rstrip(":").replace("|", "\\|").replace("``", "`")


def _write(path: Path, text: str) -> None:
    """Write a page if it changed, so that Sphinx reads again only what is new."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def _math(translator: Any, node: nodes.Node) -> None:
    markup = latex2mathml.tex2mathml(node.astext(), as_block=isinstance(node, nodes.math_block))
    translator.body.append(markup)
    raise nodes.SkipNode


def _plain_bars(
    _app: Any, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]
) -> None:
    """Keep |x| and * of formulas as they are: docstrings use them for sizes, not for markup."""
    in_example = False
    for i, line in enumerate(lines):
        in_example = line.strip().startswith(">>>") or (in_example and bool(line.strip()))
        if in_example or line.strip().startswith("*"):
            continue
        parts = re.split(r"(``.*?``)", line)
        parts[::2] = [re.sub(r"([|*])", r"\\\1", part) for part in parts[::2]]
        lines[i] = "".join(parts)
    _keep_raises_as_text(lines)


def _skip_internal(
    _app: Any, _what: str, name: str, _object: Any, skip: bool, _options: Any
) -> bool:
    """Leave out what entries of a scene check, and how their sentences call them."""
    return skip or name.startswith("check_") or name == "wording"


def _public_signature(
    _app: Any, _what: str, _name: str, _object: Any, _options: Any, signature: Any, returned: Any
) -> tuple[str, str] | None:
    """Leave out parameters that begin with an underscore; None keeps a signature as it is."""
    if not signature:
        return None
    return re.sub(r"(, \*)?, _\w+=[^,)]*(\(\))?(?=[,)])", "", signature), returned


def _keep_raises_as_text(lines: list[str]) -> None:
    """Make a heading of "Raises:": several errors share a sentence, which napoleon would split."""
    for i in range(len(lines) - 1, -1, -1):
        if lines[i].strip() != "Raises:":
            continue
        indent = len(lines[i]) - len(lines[i].lstrip())
        end = i + 1
        while end < len(lines) and (
            not lines[end].strip() or len(lines[end]) - len(lines[end].lstrip()) > indent
        ):
            end += 1
        entries: list[str] = []
        for line in lines[i + 1 : end]:
            begins = len(line) - len(line.lstrip()) == indent + 4 and line.strip()
            entries.append(" " * indent + ("- " if begins else "  ") + line.strip())
        lines[i:end] = [" " * indent + ".. rubric:: Raises", "", *entries, ""]


def _make(app: Any) -> None:
    # Pages are read, and their cells run, by as many processes as there are cores.
    app.parallel = max(app.parallel, os.cpu_count() or 1)
    begin = time.perf_counter()
    count = write_reference()
    SAY(f"reference: {count} pages from docstrings; now the examples are run and drawn")
    write_gallery(SAY, _write)
    SAY(
        f"gallery: {time.perf_counter() - begin:.0f} s; now Sphinx reads pages and runs their cells"
    )


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx; it calls this."""
    app.add_html_math_renderer("mathml", (_math, None), (_math, None))
    app.connect("builder-inited", _make)
    # Before napoleon, whose own markup stays.
    app.connect("autodoc-process-docstring", _plain_bars, priority=400)
    app.connect("autodoc-skip-member", _skip_internal)
    app.connect("autodoc-process-signature", _public_signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
