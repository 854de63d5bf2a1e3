"""How the documentation is built: ``python3 dev.py docs`` from the root of the project."""

import os
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import jupytext
from sphinx.application import Sphinx

import legspring
from legspring.files import code_stamp

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))
QUICK = os.environ.get("LEGSPRING_DOCS") == "quick"
"""Whether the long pages are left as they are: shown, but not executed."""
LONG = ["findings", "gallery/thesis", "gallery/figures", "gallery/presets", "model/optimal"]
LONG += [f"howto/{name}" for name in ("atlas", "basins", "figures", "follow", "optimise", "pareto", "robustness")]
LONG += ["howto/sweep", "howto/thesis"]
LONG += [f"notebooks/{name}" for name in ("branches", "cockroach", "lateral", "limping", "own_animal")]

project, author = "Legspring", "The Legspring developers"
copyright = "The Legspring developers"
version = release = legspring.__version__

extensions = [
    "command",
    "mathml",
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "sphinx_design",
]
exclude_patterns = ["_build", "_ext", "_made"]
html_math_renderer = "mathml"
math_eqref_format = "({number})"
nitpicky = True
# Types of other packages, and words in docstrings that stand where a type does.
nitpick_ignore_regex = [("py:.*", r"(?!legspring).*"), ("py:.*", r"legspring\.\w+\.[A-Z]\w*T")]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False

nb_execution_mode = "cache"
# What an earlier version of the package has shown is not to be seen.
kept = HERE / "_build" / "notebooks" / f"legspring-{code_stamp().replace(' ', '-')}"
nb_execution_cache_path = str(kept)
for old in kept.parent.glob("legspring-*"):
    if old != kept:
        shutil.rmtree(old)
nb_execution_excludepatterns = [f"{name}.md" for name in LONG] if QUICK else []
pages_not_run = LONG if QUICK else []
nb_execution_timeout = 900
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True
nb_render_text_lexer = "none"
# Pages are executed where their files do no harm, and whatever the reader's own settings of IPython are.
os.environ |= {"LEGSPRING_PAGES": str(HERE / "_build" / "pages"), "IPYTHONDIR": str(HERE / "_build" / "ipython")}
profile = HERE / "_build" / "ipython" / "profile_default"
for folder in (HERE / "_build" / "pages", profile):
    folder.mkdir(parents=True, exist_ok=True)
(profile / "ipython_kernel_config.py").write_text("c.IPKernelApp.log_level = 'ERROR'\n")

# `legspring.atlas` in a docstring is a link to it, if it has a page.
default_role = "autolink"
autosummary_generate = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

html_theme = "pydata_sphinx_theme"
html_title = "Legspring"
html_static_path = ["_static"]
html_css_files = ["legspring.css"]
html_show_sourcelink = False
# Pages without others beside them need no list of these.
html_sidebars = {name: [] for name in ("index", "start", "scope", "numerics", "findings")}
html_copy_source = False
html_theme_options: dict[str, Any] = {
    "logo": {"text": "Legspring"},
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "show_toc_level": 2,
    "header_links_before_dropdown": 10,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "pygments_light_style": "tango",
    "pygments_dark_style": "github-dark",
}


def save_notebooks(app: Sphinx, error: Exception | None) -> None:
    """Save the notebooks beside their pages, in the form that Jupyter opens."""
    if error is None and app.builder.format == "html":
        for page in sorted((HERE / "notebooks").glob("*.md")):
            notebook = jupytext.read(page)
            if page.stem != "index":
                jupytext.write(notebook, Path(app.outdir) / "notebooks" / f"{page.stem}.ipynb")


def without_ways_back(app: Sphinx, page: str, template: str, context: dict[str, Any], tree: object) -> None:
    """Leave out links from the source to the reference: they seek names at home, not where they are documented."""
    if page.startswith("_modules/"):
        context["body"] = re.sub(r'<a class="viewcode-back".*?</a>', "", context["body"])


def setup(app: Sphinx) -> None:
    """Save the notebooks once all is built."""
    app.connect("html-page-context", without_ways_back)
    app.connect("build-finished", save_notebooks)
