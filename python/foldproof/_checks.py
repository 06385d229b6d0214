"""Checks of whole motions."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from ._contacts import Contacts
from ._errors import Error
from ._plot import plot
from ._text import many, same

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._core import Model, Motion, _Frames, _Parts, _Path, _Progress, _Rows, _StepSettings


@dataclass(frozen=True, eq=False, repr=False)
class CheckResult:
    """Answer of a whole check. Results are equal when they found the same; times and work are not compared.

    clean: no triangles cross in the first frame and nothing collides in any step, so that nothing intersects at any time;
    with steps_only or static, only what they test counts. collisions: the number of colliding pairs, over all steps.
    contacts: what they join into (docs/contacts.md), the worst first. steps: structured array, a row per step: number,
    frame, next_frame, substep; vertex_face, edge_edge, crossings (how many); earliest_toi (in [0, 1], 1 when nothing
    collides), milliseconds. vertex_face, edge_edge: as in StepResult, with the step's number in front; empty with
    keep=False. crossings: with static, as in StaticResult, with the step's number in front; empty with keep=False.
    starts_crossing: the number of pairs of triangles that cross in the first frame, exact; None with steps_only or static,
    which do not test it. start_crossings: these pairs, as StaticResult.crossings; empty with keep=False. missed: mode
    'paper', collisions of the proven answer that it misses, over all steps. tolerance: the largest of a step, mesh units.
    work, milliseconds: sums over the steps, as in StepResult. first_frame: the first that was checked. notes: what the
    readers of the motions left out or assumed (Motion.notes), after the motion's name. verdict: what the program says,
    a sentence that claims freedom only where everything was tested, and names what was not. untested: what the settings left
    out, a sentence each. assumed: what files were taken for, such as ' between 3 frames of one mesh'; empty if nothing.
    static: whether frames were checked, not steps. statistical: mode 'paper', which can miss collisions. still_crossing:
    the number of pairs of triangles that cross in the first frame among objects that stand still, which do not count as collisions; None if there are none, or with still_pairs or steps_only.
    """

    clean: bool
    collisions: int
    steps: _Rows
    vertex_face: _Rows
    edge_edge: _Rows
    crossings: _Rows
    starts_crossing: int | None
    still_crossing: int | None
    start_crossings: _Rows
    missed: int
    tolerance: float
    work: dict[str, int]
    milliseconds: dict[str, float]
    first_frame: int
    notes: list[str]
    verdict: str
    untested: list[str]
    assumed: str
    statistical: bool
    static: bool
    _contacts: Contacts | None

    __module__ = "foldproof"
    __hash__ = None  # type: ignore[assignment]

    @property
    def contacts(self) -> Contacts:
        """What collides and crosses, joined into contacts, the worst first.

        Error: contacts were not looked for, because of contacts=False, earliest_only or mode='paper'.
        """
        if self._contacts is None:
            raise Error("contacts", "were not looked for", "check with contacts=True, for all collisions")
        return self._contacts

    @property
    def has_contacts(self) -> bool:
        """Whether contacts were looked for."""
        return self._contacts is not None

    def plot(self) -> Any:
        """A matplotlib Figure: the colliding pairs of each step, and when the worst contacts begin, are worst and end.

        ImportError: Matplotlib is not there.
        """
        return plot(self)

    def __eq__(self, other: Any) -> bool:
        if not isinstance(other, CheckResult):
            return NotImplemented
        return all(same(a, b) for a, b in zip(self._found(), other._found()))

    def _found(self) -> Iterable[Any]:
        yield from (self.clean, self.collisions, self.starts_crossing, self.still_crossing, self.missed, self.tolerance, self.static)
        yield from (self.untested, self.statistical)
        yield from (self.steps[name] for name in self.steps.dtype.names or () if name != "milliseconds")
        yield from (self.vertex_face, self.edge_edge, self.crossings, self.start_crossings, self._contacts)

    def __repr__(self) -> str:
        return f"<foldproof.CheckResult: {self._summary()}>"

    def _repr_html_(self) -> str:
        contacts = self._contacts._repr_html_() if self._contacts else ""
        return f"<p>{html.escape(self._summary())}</p>{contacts}"

    def _summary(self) -> str:
        misses = f"{self.missed:,} known miss{'' if self.missed == 1 else 'es'}"
        label = [f"STATISTICAL: {misses}"] if self.statistical else []
        return "; ".join([*label, self._counts(), *self.untested, *self.notes])

    def _counts(self) -> str:
        """'12 collisions in 3 of 32 steps, 2 contacts; frame 0 starts with 4 crossing pairs of triangles'."""
        colliding = np.count_nonzero(self.steps["vertex_face"] + self.steps["edge_edge"] + self.steps["crossings"])
        noun = "frame" if self.static else "step"
        text = f"{many(self.collisions, 'collision')} in {colliding:,} of {many(len(self.steps), noun)}{self.assumed}"
        if self._contacts:
            text += f", {many(len(self._contacts), 'contact')}"
        if self.static:
            return text
        frame = f"frame {self.first_frame}"
        if self.starts_crossing is None:
            return f"{text}; {frame} was not tested for crossings"
        return f"{text}; {frame} starts with {many(self.starts_crossing, 'crossing pair')} of triangles"


def check(
    motions: Motion | Sequence[Motion],
    *,
    models: Model | Sequence[Model | None] | None = None,
    frames: _Frames = None,
    static: bool = False,
    steps_only: bool = False,
    substeps: int = 1,
    keep: bool = True,
    contacts: bool = True,
    parts: _Parts = None,
    unit: str = "",
    reports: _Path | Sequence[_Path] = (),
    ignore: Sequence[tuple[str, str]] = (),
    still_pairs: bool = False,
    progress: _Progress = None,
    **settings: Unpack[_StepSettings],
) -> CheckResult:
    """Checks a Motion, or several that move together (a list): the triangles that cross in the first frame, then every
    step. No pair that touches is missing.

    models: a Model, or a list with one per motion (None for motions without one). frames: a slice, 'A:B:STEP' or None
    for all. static: find the triangles that cross in each frame, instead of collisions in steps. steps_only: do not
    test the first frame for crossings. substeps: linear parts that a step is divided into. keep: keep every colliding
    pair (some 40 bytes each); else only counts and contacts. contacts: join what collides into contacts. parts: names
    for their sides, one per triangle; for a list of motions a list with an entry for each, which may be None; without
    it, those that files name. unit: name of a mesh unit, for tables and reports; without it, the files'. reports:
    path or paths to write, .json, .csv or .ply (with mode='paper' only .json), which appear complete or not at all.
    ignore: pairs of objects (Motion.name) or parts, by name, that are not tested; ('a', 'a') ignores a with itself.
    still_pairs: motions opened with still=True that stand still beside others are tested against themselves and each
    other in the first frame only, and what crosses is still_crossing; with True they are tested as all others.
    progress: called with the share that is done. Ctrl-C cancels it. Error: motions that do not fit together, frames that
    cannot be read, a report that cannot be written.
    """
    found = _core.check(
        motions, models=models, frames=frames, static=static, steps_only=steps_only, substeps=substeps, keep=keep,
        contacts=contacts, parts=parts, unit=unit, reports=reports, ignore=ignore, still_pairs=still_pairs,
        progress=progress, **settings,
    )  # fmt: skip
    joined, *about = (found.pop(name) for name in ("contacts", "unit", "unknown_frames", "unlisted_pairs"))
    listed = None if joined is None else Contacts(joined, *about)
    return CheckResult(**found, static=static, _contacts=listed)


check.__doc__ = f"{check.__doc__}\n{_core.SETTINGS}"
