"""Plots of results, by Matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._checks import CheckResult

_SHOWN = 20  # contacts, the worst


def plot(found: CheckResult) -> Any:
    """A matplotlib Figure: the colliding pairs of each step, and below it when contacts begin, are worst and end."""
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError(f"plot needs Matplotlib ({error}): install python3-matplotlib, or matplotlib with pip") from None

    contacts = found.contacts[:_SHOWN] if found.has_contacts else []
    rows = 2 if contacts else 1
    figure, axes = plt.subplots(
        rows, 1, squeeze=False, sharex=True, figsize=(9, 2.5 + 0.3 * len(contacts)), layout="constrained",
        height_ratios=[2, max(1, len(contacts) * 0.3)][:rows],
    )  # fmt: skip
    pairs = axes[0, 0]
    counts = sum(found.steps[kind] for kind in ("vertex_face", "edge_edge", "crossings"))
    pairs.bar(_begin_of(found), counts, width=_width_of(found), align="center" if found.static else "edge", color="tab:red")
    pairs.set_ylabel("crossing pairs" if found.static else "colliding pairs")
    if contacts:
        _plot_contacts(axes[1, 0], contacts, found.contacts.unit)
    axes[-1, 0].set_xlabel("frame")
    return figure


def _begin_of(found: CheckResult) -> Any:
    steps = found.steps
    return steps["frame"] + steps["substep"] * _width_of(found)


def _width_of(found: CheckResult) -> Any:
    steps = found.steps
    substeps = int(steps["substep"].max(initial=0)) + 1
    return (steps["next_frame"].astype(float) - steps["frame"]).clip(1) / substeps


def _plot_contacts(axes: Any, contacts: Any, unit: str) -> None:
    deepest = max((c.depth or 0 for c in contacts), default=0) or 1
    for row, c in enumerate(contacts):
        shade = 0.25 + 0.75 * (c.depth or 0) / deepest
        axes.barh(row, c.last_time - c.first_time, left=c.first_time, height=0.7, color="tab:red", alpha=shade)
        if c.worst is not None:
            axes.plot(c.worst, row, "k|", markersize=10)
        if c.depth is not None:
            axes.annotate(f" {c.depth:.3g} {unit}".rstrip(), (c.last_time, row), va="center", fontsize="small")
    axes.set_yticks(range(len(contacts)), [f"#{c.number} {c.between}" for c in contacts], fontsize="small")
    axes.invert_yaxis()
    axes.set_title("contacts, the worst first; a line marks the worst frame", fontsize="medium")
