"""The documentation is true: its cells run, its commands print what is shown, its links lead on."""

import doctest
import pathlib
import re
import shlex
import tomllib

import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import main

ROOT = pathlib.Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(
    path
    for path in DOCS.rglob("*.md")
    if not {"_build", "_generated"} & set(path.relative_to(DOCS).parts)
)
FENCE = re.compile(r"^(`{3,})([^\n]*)\n(.*?)^\1$", re.M | re.S)


def name(path):
    return str(path.relative_to(DOCS))


def blocks(path):
    """(language or directive, body) of each fenced block."""
    return [(kind.strip(), body) for _, kind, body in FENCE.findall(path.read_text("utf-8"))]


def cells(path):
    return [body for kind, body in blocks(path) if kind.startswith("{code-cell}")]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder to work in, as a checkout has it."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
    for part in ("models", "examples"):
        (tmp_path / part).symlink_to(ROOT / part)
    monkeypatch.chdir(tmp_path)
    return tmp_path


# What the sentences of a page say of its numbers, in the names of its cells.
CLAIMS = {
    "notebooks/first_impact.md": (
        "abs(energy.change - sum(energy.work.values())) < 1e-12",
        # The load falls from the hand to the shoulder.
        "list(loads.values())[0] > list(loads.values())[-1]",
        "braked.is_valid() and abs(braked.dv[6 + names.index('arm_left_4_joint')]) < 1e-12",
    ),
    "notebooks/motion_and_replay.md": (
        "np.ptp(energy) < 1e-6 * abs(energy[0])",
        "(again.q == motion.q).all()",
    ),
    "notebooks/contacts_and_laws.md": (
        "np.allclose(found, closed, rtol=1e-9)",
        # Each law has its own energy where friction stops the slip.
        "np.diff(sorted(share.values())).min() > 0.003",
        "all(hit.contacts[0].mode == 'sticking' for hit in impacts.values())",
        # Laws of the end and of the path agree where it slides throughout.
        "np.allclose(curves['newton, end'][-1], curves['newton, path'][-1], rtol=1e-9)",
        "np.allclose(curves['poisson, end'][0], curves['stronge, path'][0], rtol=1e-9)",
        "all(abs(hit.contacts[0].impulse[0]) <= 0.3 * hit.contacts[0].impulse[2] + 1e-12"
        " for hit in impacts.values())",
        "0.1 < mu[np.argmin(batch.energy_change)] < 0.35",
    ),
    "notebooks/batch_and_study.md": ("batch.valid.all()", "len(rows.energy_change) == 2000"),
    "notebooks/fit.md": (
        "np.all(abs(fit.values - [0.82, 0.27]) < 3 * np.sqrt(np.diag(fit.covariance)))",
        "0.8 < fit.residuals.std() < 1.2",
    ),
    "explanation/method.md": (
        "problem.residual(found.impulses) < 1e-12",
        "np.allclose(found.v_after, ik.solve(scene, q, v).v_after, atol=1e-13)",
    ),
    "howto/mujoco.md": (
        "all(abs(hit.separation[0] - 0.8 * hit.approach[0]) < 1e-12 for hit in hits)",
    ),
}


def test_every_notebook_has_claims():
    notebooks = {name(p) for p in PAGES if p.parent.name == "notebooks" and cells(p)}
    assert notebooks <= set(CLAIMS)


@pytest.mark.slow
@pytest.mark.parametrize("path", [p for p in PAGES if cells(p)], ids=name)
def test_the_cells_of_a_page_run(path, folder):
    import matplotlib.pyplot as plt

    for extra in ("torch", "jax"):
        if any(f"import {extra}\n" in cell for cell in cells(path)):
            pytest.importorskip(extra)
    names = {"__name__": "page"}
    for number, cell in enumerate(cells(path)):
        exec(compile(cell, f"{name(path)}, cell {number}", "exec"), names)
    for claim in CLAIMS.get(name(path), ()):
        assert eval(claim, names), claim
    plt.close("all")


@pytest.mark.parametrize("path", PAGES, ids=name)
def test_code_lines_fit_the_column(path):
    for kind, body in blocks(path):
        if kind.startswith(("{code-cell}", "toml", "bash", "console", "text")):
            assert max(map(len, body.splitlines()), default=0) <= 100


@pytest.mark.parametrize("path", PAGES, ids=name)
def test_python_is_run_and_not_only_shown(path):
    kinds = [kind for kind, _ in blocks(path)]
    assert "python" not in kinds
    # A page with cells says so to the build.
    if cells(path):
        assert path.read_text("utf-8").startswith("---\nfile_format: mystnb\n")


@pytest.mark.parametrize(
    ("path", "block"),
    [(p, body) for p in PAGES for kind, body in blocks(p) if kind == "console"],
    ids=lambda value: name(value) if isinstance(value, pathlib.Path) else "",
)
def test_commands_print_what_is_shown(path, block, folder):
    command, _, shown = block.partition("\n")
    assert command.startswith("$ impulsekit ")
    result = CliRunner().invoke(main, shlex.split(command)[2:])
    assert result.exit_code == 0, result.output
    checker = doctest.OutputChecker()
    assert checker.check_output(shown, result.stdout, doctest.ELLIPSIS), result.stdout


@pytest.mark.parametrize(
    "block", [body for path in PAGES for kind, body in blocks(path) if kind == "toml"]
)
def test_scene_files_are_read(block, folder):
    tomllib.loads(block)
    (folder / "scenes").mkdir()
    path = folder / "scenes/scene.toml"
    path.write_text(block, encoding="utf-8")
    file = ik.load_scene(path)
    assert ik.solve(file.scene, file.q, file.v).is_valid()


@pytest.mark.parametrize("path", PAGES, ids=name)
def test_links_lead_somewhere(path):
    text = FENCE.sub("", path.read_text("utf-8"))
    for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
        # What the build makes is examined after it.
        made = link.startswith(("https://", "../_generated/"))
        assert made or (path.parent / link).exists(), link
    for link in re.findall(r"\{doc\}`(?:[^<`]*<)?([^>`]+)>?`", text):
        assert (path.parent / f"{link}.md").exists(), link


def test_every_page_is_in_a_table_of_contents():
    listed = {DOCS / "index.md"}
    for path in PAGES:
        for kind, body in blocks(path):
            if kind == "{toctree}":
                entries = [e for e in body.splitlines() if e and not e.startswith(":")]
                for entry in entries:
                    listed |= set(path.parent.glob(f"{entry}.md"))
    assert set(PAGES) <= listed


def test_the_map_has_every_public_name_and_status():
    page = (DOCS / "explanation/map.md").read_text("utf-8")
    named = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`]+)`", page))))
    assert set(ik.__all__) <= named
    for statuses in (ik.Status, ik.MotionStatus):
        assert {status.name for status in statuses} <= named
    for status in ik.Status:
        row = next(row for row in page.splitlines() if f"`{status.name}`" in row)
        valid, _, _ = row.split("|")[2:5]
        assert (f"`{status.name}`" in valid) == status.valid


def test_every_command_is_explained():
    page = (DOCS / "command.md").read_text("utf-8")
    for command in main.commands:
        assert f"`impulsekit {command}" in page


def test_every_public_name_is_in_the_reference(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    make_pages = pytest.importorskip("make_pages", reason="docutils comes with [docs]")
    named = {entry[0] for entry in make_pages.public_names().values()}
    modules = {"errors", "plots", "design", "measured", "study", "long", "models"}
    for public in set(ik.__all__) - modules:
        value = getattr(ik, public)
        if not isinstance(value, str | type(pytest)):
            assert any(entry.endswith(f".{public}") for entry in named), public
            assert make_pages.page_of(value)
