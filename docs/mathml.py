"""Equations as MathML, which browsers draw by themselves: no page needs a script from elsewhere."""

from docutils import nodes
from latex2mathml.converter import convert


def inline(self, node):
    """An equation in a line."""
    self.body.append(convert(node.astext()))
    raise nodes.SkipNode


def block(self, node):
    """An equation of its own."""
    self.body.append(f'<div class="math">{convert(node.astext(), display="block")}</div>')
    raise nodes.SkipNode


def setup(app):
    """Called by Sphinx."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True}
