"""Sphinx's settings. Pages under _generated come from docstrings and examples at every build."""

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent
GENERATED = HERE / "_generated"
sys.path.insert(0, str(HERE))

import impulsekit  # noqa: E402

project = "impulsekit"
author = "the impulsekit developers"
copyright = "2026, the impulsekit authors"
release = version = impulsekit.__version__
html_title = f"impulsekit {version}"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "make_pages",
]
exclude_patterns = ["_build", "_generated/work", "_generated/moving", "**/.ipynb_checkpoints"]
# An attribute that several results have, such as constraints, is no broken reference.
suppress_warnings = ["mystnb.unknown_mime_type", "toc.empty_glob", "ref.python"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "substitution"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_cache_path = str(GENERATED / "cache")
nb_execution_timeout = 240
nb_output_stderr = "remove"
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True}
napoleon_use_ivar = True
napoleon_use_rtype = False
napoleon_use_admonition_for_examples = False

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["tables.css"]
# Replays of the gallery: self-contained HTML, copied as it is.
html_extra_path = ["_generated/extra"]
html_copy_source = False
html_show_sourcelink = False
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
pygments_style = "friendly"

# Formulas are MathML, which browsers read themselves: no script, no fonts, no network.
html_math_renderer = "mathml"

for folder in ("extra/moving", "work", "ipython/profile_default/startup"):
    (GENERATED / folder).mkdir(parents=True, exist_ok=True)
# Cells run in a folder of their own with links to models and examples: what they write stays there.
for name in ("models", "examples"):
    link = GENERATED / "work" / name
    if not link.exists():
        link.symlink_to(ROOT / name, target_is_directory=True)
(GENERATED / "ipython/profile_default/startup/folder.py").write_text(
    f"import os\nos.chdir({str(GENERATED / 'work')!r})\n", encoding="utf-8"
)
# The build says what it does; kernels' warnings would hide it.
(GENERATED / "ipython/profile_default/ipython_kernel_config.py").write_text(
    "get_config().IPKernelApp.log_level = 40\n", encoding="utf-8"
)
os.environ["IPYTHONDIR"] = str(GENERATED / "ipython")
os.environ.setdefault("MPLBACKEND", "module://matplotlib_inline.backend_inline")
