"""Text and HTML of tables, and comparison of values that hold arrays."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

import numpy as np

NUMERIC = set("0123456789,.-+e")


def many(count: int, noun: str) -> str:
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def text_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Aligned columns; numbers to the right."""
    widths = [max(map(len, column)) for column in zip(header, *rows)]
    right = [_is_numeric(column) for column in zip(*rows)]
    lines = []
    for row in (header, *rows):
        cells = [cell.rjust(w) if r else cell.ljust(w) for cell, w, r in zip(row, widths, right)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def html_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    right = [_is_numeric(column) for column in zip(*rows)]

    def line(kind: str, cells: Sequence[str]) -> str:
        styled = (
            f'<{kind} style="text-align:{"right" if r else "left"}">{html.escape(cell)}</{kind}>'
            for cell, r in zip(cells, right)
        )
        return f"<tr>{''.join(styled)}</tr>"

    return f"<table><thead>{line('th', header)}</thead><tbody>{''.join(line('td', row) for row in rows)}</tbody></table>"


def _is_numeric(column: Sequence[str]) -> bool:
    return all(set(cell) <= NUMERIC for cell in column)


def same(a: Any, b: Any) -> bool:
    """Equality of values, sequences and arrays, in which NaN equals NaN."""
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        if a.dtype.names:
            return a.shape == b.shape and a.dtype == b.dtype and all(same(a[name], b[name]) for name in a.dtype.names)
        return np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if isinstance(a, (tuple, list)) and isinstance(b, (tuple, list)):
        return len(a) == len(b) and all(map(same, a, b))
    return bool(a == b)
