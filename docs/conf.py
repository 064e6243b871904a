"""Settings of the documentation: `sphinx-build -W docs docs/_build/html`."""

import importlib.metadata
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

project = "lumpedcable"
release = version = importlib.metadata.version("lumpedcable")
author = "the lumpedcable authors"
copyright = "the lumpedcable authors, Apache License 2.0"

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "gallery", "mathml"]
html_math_renderer = "mathml"
myst_enable_extensions = ["fieldlist", "dollarmath"]
nb_execution_mode = "off"  # notebooks are kept with what came out: python docs/notebooks.py
myst_heading_anchors = 4
# pages are also read on GitHub, where a link may lead to any file of the repository
exclude_patterns = ["_build", "images/*.md"]
# the build checks links between pages; links to other sites, with the network,
# LUMPEDCABLE_GALLERY= sphinx-build -b linkcheck docs docs/_build/links
linkcheck_timeout = 20
linkcheck_retries = 2
linkcheck_anchors = False
linkcheck_ignore = [r"http://127\.0\.0\.1"]
suppress_warnings = ["myst.strikethrough"]

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_format = "short"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
nitpicky = False

html_theme = "furo"
html_title = f"lumpedcable {version}"
html_static_path: list[str] = []
pygments_style = "friendly"
pygments_dark_style = "native"
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0072B2", "color-brand-content": "#0072B2"},
    "dark_css_variables": {"color-brand-primary": "#56B4E9", "color-brand-content": "#56B4E9"},
}


def plain(app, what, name, obj, options, lines):
    """A bar in a docstring is a magnitude, not reStructuredText."""
    lines[:] = [line.replace("|", r"\|") for line in lines]


def setup(app):
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", plain)
