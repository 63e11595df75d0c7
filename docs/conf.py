"""Sphinx configuration."""

from __future__ import annotations

import os
from importlib.metadata import version as _version
from typing import Any

project = "stepid"
author = "The stepid developers"
copyright = "The stepid developers"
release = version = _version("stepid")

os.environ["STEPID_PROGRESS"] = "0"  # of the notebooks: the widgets of bars would need the network

extensions = [
    "myst_nb",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx-mathjax-offline",  # formulas need no network: MathJax and its fonts are part of the site
]
if os.environ.get("STEPID_DOCS_LINKS"):  # needs the network: links from types and functions to other projects' pages
    extensions.append("sphinx.ext.intersphinx")
    intersphinx_mapping = {
        "python": ("https://docs.python.org/3", None),
        "numpy": ("https://numpy.org/doc/stable", None),
        "scipy": ("https://docs.scipy.org/doc/scipy", None),
        "control": ("https://python-control.readthedocs.io/en/stable", None),
        "pandas": ("https://pandas.pydata.org/docs", None),
        "matplotlib": ("https://matplotlib.org/stable", None),
    }
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True  # of a console, the commands; blocks without a prompt whole
exclude_patterns = ["_build", "jupyter_execute", ".jupyter_cache"]
nb_execution_mode = "cache"  # notebooks are kept without outputs; -D nb_execution_mode=off builds without running them
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_kernel_rgx_aliases = {".*": "python3"}
nb_merge_streams = True

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_title = f"stepid {release}"

nitpicky = True
add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # types and units stand in the numpydoc sections
autodoc_preserve_defaults = True  # a default is shown as it is written, CATALOGUE and not all its effects
autodoc_default_options = {"members": True, "exclude-members": "model_config, model_fields, model_computed_fields"}
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
napoleon_use_ivar = True


def _keep_bars(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Keep |x| an absolute value: reStructuredText takes it for a substitution."""
    lines[:] = [line.replace("|", "\\|") for line in lines]


def _keep_colons(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Keep the sentence of a property a sentence: napoleon takes what stands before its first colon for a type."""
    if what in ("attribute", "property") and lines:
        lines[0] = lines[0].replace(": ", " – ")


def setup(app: Any) -> None:
    app.connect("autodoc-process-docstring", _keep_colons, priority=100)
    app.connect("autodoc-process-docstring", _keep_bars, priority=900)
