"""What is published: its metadata agree, and the wheel holds what the program reads."""

import importlib.metadata
import pathlib
import subprocess
import tomllib

import pytest

import impulsekit

ROOT = pathlib.Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
LARGEST_WHEEL = 5_000_000  # bytes


def test_the_version_is_the_same_everywhere():
    assert PROJECT["version"] == impulsekit.__version__
    citation = (ROOT / "CITATION.cff").read_text()
    assert f"version: {PROJECT['version']}" in citation.splitlines()
    assert f"license: {PROJECT['license']}" in citation.splitlines()
    assert f"## {PROJECT['version']}" in (ROOT / "CHANGELOG.md").read_text()


def test_links_are_there():
    assert {"Homepage", "Source", "Documentation", "Changelog", "Issues"} <= set(PROJECT["urls"])
    assert all(url.startswith("https://") for url in PROJECT["urls"].values())


def test_the_conda_recipe_needs_what_the_wheel_needs():
    recipe = (ROOT / ".ci/conda/meta.yaml").read_text()
    run = recipe.split("  run:\n")[1].split("\n\n")[0]
    listed = {line.strip("- ").split(" ", 1)[0]: line for line in run.splitlines()}
    renamed = {"pin": "pinocchio", "meshcat": "meshcat-python"}
    for need in PROJECT["dependencies"]:
        name, bound = need.split(">=")
        line = listed.pop(renamed.get(name, name))
        assert line.endswith(f">={bound}"), line
    assert set(listed) == {"python"}


def test_the_release_workflow_runs_what_it_names():
    workflow = (ROOT / ".github/workflows/release.yml").read_text()
    for word in (".ci/run", "python -m build", "twine check", "pip install -q dist/*.whl"):
        assert word in workflow
    assert (ROOT / ".ci/run").exists()
    assert f"{LARGEST_WHEEL}" in workflow


def test_what_is_installed_is_whole_and_small():
    """What pip has built and installed; the release's own workflow looks at the wheel's size."""
    files = importlib.metadata.files("impulsekit") or []
    names = {str(file) for file in files}
    if "impulsekit/__init__.py" not in names:
        pytest.skip("an editable install, of which nothing is copied")
    tracked = subprocess.run(
        ["git", "ls-files", "impulsekit"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split("\n")
    assert set(filter(None, tracked)) <= names
    assert sum(name.startswith("impulsekit/_core.") and ".so" in name for name in names) == 1
    assert not any("tests/" in name or name.endswith((".svg", ".png")) for name in names)
    assert sum(file.size or 0 for file in files) < 4 * LARGEST_WHEEL
