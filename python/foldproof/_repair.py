"""Repair of motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import _core
from ._contacts import Contacts
from ._text import many

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._core import Model, Motion, _Frames, _Progress, _Rows

LIMITS = ("none", "no_free_start", "given_up")


@dataclass(frozen=True, eq=False, repr=False)
class RepairResult:
    """Answer of a repair.

    free: proven that nothing that was not ignored touches, in no frame and at no time between frames, but maybe what may
    not move, with itself: among_fixed has its contacts, which are in no other list. unchanged: the motion was free,
    and is as it was. motions: the repaired motions, one per object, with all frames that were asked for; empty where
    there was no free start. verdict: what is proven, what still touches, what was left and what was not tested, in a
    sentence. frames: structured array, a row per frame: time (the frame's number), correction (the largest distance that
    a vertex was moved, mesh units), late (the correction could not keep up with the motion), limit (why it is not free,
    an index into LIMITS). before, remaining: contacts of the input and of the result. left: contacts of the result that
    were not to be repaired (contacts=); then free, before and remaining are about the others. falloff: how far
    corrections spread, clearance: how far apart surfaces are kept beyond the thickness; mesh units, 0 where nothing was
    repaired.
    """

    free: bool
    unchanged: bool
    verdict: str
    motions: list[Motion]
    frames: _Rows
    before: Contacts
    remaining: Contacts
    left: Contacts
    among_fixed: Contacts
    falloff: float
    clearance: float

    __module__ = "foldproof"

    def __repr__(self) -> str:
        text = "free" if self.free else f"{many(len(self.remaining), 'contact')} remain"
        if self.left:
            text += f" of those chosen, {many(len(self.left), 'contact')} left"
        moved = int(np.count_nonzero(self.frames["correction"]))
        return f"<foldproof.RepairResult: {text}; {many(len(self.before), 'contact')} before, {many(moved, 'frame')} moved>"


def repair(
    motions: Motion | Sequence[Motion],
    *,
    thickness: float = 0,
    falloff: float = 0,
    fixed: Sequence[str] = (),
    fixed_vertices: Sequence[ArrayLike] = (),
    only: Sequence[str] = (),
    ignore: Sequence[tuple[str, str]] = (),
    contacts: Sequence[tuple[str, str]] = (),
    frames: _Frames = None,
    start: ArrayLike | None = None,
    models: Model | Sequence[Model | None] | None = None,
    single_precision: bool = False,
    calm: bool = True,
    progress: _Progress = None,
) -> RepairResult:
    """The nearest motion that touches nothing, proven frame by frame and between frames (docs/repair.md).

    motions: a Motion, or several that move together (a list). thickness: nothing comes as close as this, mesh units.
    falloff: how far along the surface a correction spreads, mesh units; 0: a twentieth of the size. fixed: names of
    objects (Motion.name) or parts that may not move. fixed_vertices: ids of vertices that may not, an array for each
    motion; empty: all may. only: names of those that may; then no others do. ignore: pairs of names that may touch;
    ('a', 'a'): a with itself. contacts: pairs of names; only contacts between the two of a pair are repaired, all others
    are left. Empty: all are repaired. frames: a slice or 'A:B', without gaps; None for all. start: positions (V x 3, of
    all objects one after the other) that touch nothing, from which the first frame is approached; None: a frame that is
    free, or one that can be untangled. models: one per motion (foldproof.train), None for motions without one: where no
    frame is free, a repair may start in one of their training poses. single_precision: positions are rounded to float32
    before they are proven, for files that hold no more. calm: a second pass makes corrections calm in time. progress:
    called with the share that is done. Ctrl-C cancels it. Error: motions that do not fit together, a name that is
    neither an object's nor a part's, a vertex that does not exist, a thickness that the mesh itself does not keep,
    nothing that may move, a start that touches itself, a model of another mesh or that has learned no shapes.
    """
    begin = [] if start is None else np.asarray(start, dtype=float).ravel().tolist()
    vertices = [np.asarray(each, dtype=np.int64).ravel().tolist() for each in fixed_vertices]
    found = _core.repair(
        motions, thickness=thickness, falloff=falloff, fixed=list(fixed), fixed_vertices=vertices, only=list(only),
        ignore=list(ignore), contacts=list(contacts), frames=frames, start=begin, models=models,
        single_precision=single_precision, calm=calm, progress=progress,
    )  # fmt: skip
    unit = found.pop("unit")
    before, remaining, left, among_fixed = (
        Contacts(found.pop(name), unit) for name in ("before", "remaining", "left", "among_fixed")
    )
    return RepairResult(**found, before=before, remaining=remaining, left=left, among_fixed=among_fixed)
