"""Formulas as MathML, which browsers draw by themselves: no script, and nothing from another site."""

from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx


def inline(writer: Any, node: nodes.math) -> None:
    """Write a formula in a line of text."""
    writer.body.append(f'<span class="math">{convert(node.astext())}</span>')
    raise nodes.SkipNode


def displayed(writer: Any, node: nodes.math_block) -> None:
    """Write a formula of its own, with its number if it has a label."""
    writer.body.append('<div class="math-display">')
    number = node.get("number")
    if number:
        anchor = f"equation-{node['label']}"
        writer.body.append(f'<span class="eqno" id="{anchor}">({number})</span>')
    writer.body.append(convert(node.astext(), display="block"))
    writer.body.append("</div>")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Take the place of Sphinx's own ways to show formulas."""
    app.add_html_math_renderer("mathml", (inline, None), (displayed, None))  # type: ignore[arg-type]
    return {"parallel_read_safe": True, "parallel_write_safe": True}
