"""What is published: its metadata agree, and the wheel holds what the program reads."""

import importlib
import importlib.metadata
import pathlib
import subprocess
import tomllib

import pytest

import impulsekit

ROOT = pathlib.Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
LARGEST_WHEEL = 4_000_000  # bytes


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


def test_wheels_are_built_for_what_the_classifiers_name():
    workflow = (ROOT / ".github/workflows/release.yml").read_text()
    assert "pypa/cibuildwheel" in workflow
    assert f"-le {LARGEST_WHEEL}" in workflow
    for archs in ("x86_64", "aarch64", "arm64"):
        assert f"archs: {archs}" in workflow
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]
    assert settings["cibuildwheel"]["manylinux-x86_64-image"] == "manylinux_2_28"
    oldest = settings["scikit-build"]["wheel"]["py-api"]
    pythons = [
        "cp3" + word.rsplit(".", 1)[1]
        for word in PROJECT["classifiers"]
        if word.startswith("Programming Language :: Python :: 3.")
    ]
    # One wheel before the stable ABI, one for it, tested on the oldest and the newest.
    assert settings["cibuildwheel"]["build"] == [
        f"{name}-*" for name in (pythons[0], oldest, pythons[-1])
    ]


@pytest.mark.parametrize("path", ["tests/wheel", ".ci/run", "core/build.sh", "core/sanitize.sh"])
def test_workflows_run_what_is_there(path):
    texts = [file.read_text() for file in (ROOT / ".github/workflows").glob("*.yml")]
    assert any(path in text for text in texts)
    assert (ROOT / path).exists()


@pytest.mark.parametrize(
    ("platform", "version", "word"),
    [("win32", (3, 12), "WSL"), ("linux", (3, 15), "Python 3.11 to 3.14")],
)
def test_a_platform_without_pinocchio_is_told_before_pip_searches(
    monkeypatch, platform, version, word
):
    monkeypatch.syspath_prepend(ROOT / "core/build_backend")
    backend = importlib.import_module("impulsekit_build")
    monkeypatch.setattr(backend.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(backend.sys, "platform", platform)
    monkeypatch.setattr(backend.sys, "version_info", version)
    with pytest.raises(SystemExit, match=word):
        backend.check_platform()


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
    assert sum(name.startswith("impulsekit/_lib/libimpulsekit_core.") for name in names) == 1
    assert not any("tests/" in name or name.endswith((".svg", ".png")) for name in names)
    assert sum(file.size or 0 for file in files) < 4 * LARGEST_WHEEL
