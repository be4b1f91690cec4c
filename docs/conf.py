"""The site of the documentation, for Sphinx; docs/site.py calls it."""

import tomllib
from pathlib import Path

_PACKAGE = tomllib.loads((Path(__file__).parents[1] / "Cargo.toml").read_text())["workspace"][
    "package"
]

project = "halfline"
author = "the halfline developers"
project_copyright = f"{author}; {_PACKAGE['license']}"
version = release = _PACKAGE["version"]
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]

# Anchors as on the pages of the repository.
myst_heading_anchors = 4
suppress_warnings = ["misc.highlighting_failure"]
# `Scene` in the package's documentation.
default_role = "any"
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"

html_theme = "furo"
html_title = "halfline"
html_copy_source = False
# Links to the sources of pages would be wrong for those at the root of the repository.
html_theme_options = {"top_of_page_buttons": []}


def setup(app):
    """Texts of attributes stay as they are: napoleon takes what stands before a colon for a type."""
    texts = {}

    def keep(_app, what, name, _obj, _options, lines):
        if what == "attribute":
            texts[name] = list(lines)

    def restore(_app, what, name, _obj, _options, lines):
        if what == "attribute":
            lines[:] = texts.pop(name)

    # Before and after napoleon, which has 500.
    app.connect("autodoc-process-docstring", keep, priority=400)
    app.connect("autodoc-process-docstring", restore, priority=600)
