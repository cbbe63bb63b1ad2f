"""The manual's build: ``python -m sphinx -W docs OUT``.

Sphinx with MyST, because tutorials are then plain Markdown files whose cells are run while the manual is built, and the
reference comes from the same docstrings, schema and table of quantities as the program. No page needs a service: formulas
are MathML, made while building.
"""

import os
import sys
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert
from numpydoc.validate import validate
from sphinx.application import Sphinx
from sphinx.util.logging import getLogger

sys.path.insert(0, str(Path(__file__).parent))
# commands in cells are those of the environment that builds
os.environ["PATH"] = str(Path(sys.executable).parent) + os.pathsep + os.environ["PATH"]
# cells run in an empty folder and find the manual's example programs here
os.environ["MANUAL"] = str(Path(__file__).parent)
# what cells print is the answer alone, in lines that fit the page
os.environ["ROLLBENCH_PROGRESS"] = "off"
os.environ["COLUMNS"] = "92"

import rollbench

project = "rollbench"
author = "the rollbench authors"
project_copyright = "the rollbench authors, MIT licence"
version = release = rollbench.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
exclude_patterns = []
html_theme = "furo"
html_title = f"rollbench {release}"
html_static_path = ["_static"]
html_css_files = ["manual.css"]
html_math_renderer = "mathml"
html_copy_source = False

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence", "attrs_inline"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_timeout = 420
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_merge_streams = True
copybutton_selector = "div:not(.output) > div.highlight > pre"

autodoc_typehints = "description"
autodoc_member_order = "bysource"
napoleon_use_rtype = False
suppress_warnings = ["myst.strikethrough", "myst-nb.lexer"]  # the latter where cells are not run


def inline_formula(translator: nodes.NodeVisitor, node: nodes.math) -> None:
    """An inline formula as MathML."""
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def displayed_formula(translator: nodes.NodeVisitor, node: nodes.math_block) -> None:
    """A formula on its own line as MathML; with its number where it has a label."""
    translator.body.append('<div class="formula">')
    text = node.astext().strip()
    if "&" in text or "\\\\" in text:
        text = rf"\begin{{aligned}}{text}\end{{aligned}}"
    translator.body.append(convert(text, display="block"))
    if node.get("number"):
        translator.body.append(f'<span class="eqno" id="{node["ids"][0] if node["ids"] else ""}">({node["number"]})</span>')
    translator.body.append("</div>")
    raise nodes.SkipNode


def check_docstring(_app: Sphinx, what: str, name: str, *_rest: object) -> None:
    """Warn where the docstring of a function of the library lacks a parameter, what it returns or its summary."""
    checked = {"GL06", "GL07", "GL08", "PR01", "PR02", "PR03", "PR07", "RT01", "RT03", "SS03"}
    for code, text in validate(name)["errors"] if what in ("function", "method") else ():
        if code in checked:
            getLogger(__name__).warning("%s: %s %s", name, code, text)


def write(app: Sphinx) -> None:
    """Writes the pages and drawings that the program makes."""
    import drawings
    import generate
    import layers

    generate.pages(Path(app.srcdir) / "reference")
    drawings.draw(Path(app.srcdir) / "_static")
    layers.draw(Path(app.srcdir) / "_static/layers.svg")


def setup(app: Sphinx) -> dict[str, bool]:
    """Registers the formulas and the pages that the program writes."""
    app.add_html_math_renderer("mathml", (inline_formula, None), (displayed_formula, None))
    app.connect("builder-inited", write)
    app.connect("autodoc-process-docstring", check_docstring)
    return {"parallel_read_safe": True}
