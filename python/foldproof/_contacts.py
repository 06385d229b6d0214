"""Contacts: what goes through what, where, from when to when, how deep."""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ._core import ContactFinder, Hierarchy, Model, PairFilter
from ._text import html_table, many, same, text_table

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Unpack

    from ._core import _Floats, _Ids, _Parts, _Rows, _StepSettings

_SHOWN = 20  # contacts in a table
_FRAME: list[Any] = [
    ("time", "f8"), ("crossings", "u8"), ("triangles", "u8"), ("curve_length", "f8"), ("closed", "?"), ("area", "f8", 2),
    ("depth", "f8"), ("at_least", "?"), ("touching", "?"),
]  # fmt: skip


@dataclass(frozen=True, eq=False)
class ContactSide:
    """One of the two surfaces of a contact.

    object: its number. name: of the part, or of the object where there are no parts. triangles: the ids of those that
    cross or are inside in the worst frame, ascending. inside: those of them that lie entirely inside.
    """

    object: int
    name: str
    triangles: _Ids
    inside: _Ids

    __module__ = "foldproof"
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: Any) -> bool:
        return _same_fields(self, other)


@dataclass(frozen=True, eq=False, repr=False)
class Contact:
    """Colliding features and crossing triangles that are connected on both surfaces and in time.

    Times are frames, with fractions between them; lengths are mesh units.

    number, joined: its number, in the order in which contacts begin, and those of contacts that became a part of it.
    sides: two of ContactSide. folded: both are the same piece of a surface. pierces: a line or a point goes through
    faces, and no two faces meet. from_start: it was there in the first frame. healed: it ended before the motion did. first_time, last_time: first impact; the last frame in which it crosses, or
    the last impact. pairs: colliding pairs of features, over all steps, that are listed (max_listed). depth: in
    the worst frame; None where it only touches, or pierces. at_least: both surfaces are open and pass through each
    other, so that the depth is a lower bound. touching: nothing is inside, in any frame. worst: time of the worst
    frame, that with the largest depth (a twentieth of the curves' length stands for a missing one); None where it only touches between frames, or it is not
    known what crosses (Contacts.unknown_frames). point (3), box (2 x 3: low, high), normal (3): in the worst
    frame, the deepest point or the middle of the curves, the box of the triangles, the direction out. frames: structured
    array, a row per frame in which it crosses: time, crossings (pairs of triangles), triangles (that cross or are
    inside), curve_length, closed, area (2, inside, of each side; NaN where there is no region), depth (NaN where there
    is none), at_least, touching. curves: polylines P x 3 in the worst frame; a closed one repeats its first point.
    """

    number: int
    joined: tuple[int, ...]
    sides: tuple[ContactSide, ContactSide]
    folded: bool
    pierces: bool
    from_start: bool
    healed: bool
    first_time: float
    last_time: float
    pairs: int
    depth: float | None
    at_least: bool
    touching: bool
    worst: float | None
    point: _Floats
    box: _Floats
    normal: _Floats
    frames: _Rows
    curves: tuple[_Floats, ...]

    __module__ = "foldproof"
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: Any) -> bool:
        return _same_fields(self, other)

    @property
    def between(self) -> str:
        """The names of its sides in words: 'arm - torso', 'torso with itself', 'coin with another'."""
        a, b = self.sides
        if a.name != b.name:
            return f"{a.name} - {b.name}"
        return f"{a.name} with {'itself' if a.object == b.object else 'another'}"

    @property
    def worst_frame(self) -> np.void | None:
        """The row of frames that is the worst; None where worst is."""
        if self.worst is None:
            return None
        row: np.void = self.frames[np.searchsorted(self.frames["time"], self.worst)]
        return row

    def __repr__(self) -> str:
        worst = self.worst_frame
        if worst is None:
            what = f"collides, {many(self.pairs, 'pair')}"  # and perhaps crosses, in frames that are not known
        elif self.depth is None:
            what = f"worst {self.worst:g}, crosses along {worst['curve_length']:.3g}"
        else:
            what = f"worst {self.worst:g}, {self.depth:.3g} deep"
        return f"<foldproof.Contact {self.number}: {self.between}, {_when(self)}, {what}>"


class Contacts(Sequence[Contact]):
    """Contacts of a motion, the worst first. A slice is a Contacts, too.

    unit: name of the mesh unit; empty where it was not named. unknown_frames: how many frames there are of which it is
    not known what crosses, because pairs were left out (max_listed) or with steps_only. unlisted_pairs: how many
    colliding pairs were not listed (max_listed), and are in no contact.
    """

    __module__ = "foldproof"
    __hash__ = None  # type: ignore[assignment]

    def __init__(
        self, contacts: Iterable[Contact], unit: str = "", unknown_frames: int = 0, unlisted_pairs: int = 0
    ) -> None:
        self._contacts = tuple(contacts)
        self.unit = unit
        self.unknown_frames = unknown_frames
        self.unlisted_pairs = unlisted_pairs

    def __len__(self) -> int:
        return len(self._contacts)

    @overload
    def __getitem__(self, index: int) -> Contact: ...
    @overload
    def __getitem__(self, index: slice) -> Contacts: ...
    def __getitem__(self, index: int | slice) -> Contact | Contacts:
        if isinstance(index, slice):
            return Contacts(self._contacts[index], self.unit, self.unknown_frames, self.unlisted_pairs)
        return self._contacts[index]

    def __eq__(self, other: Any) -> bool:
        return isinstance(other, Contacts) and same(self._contacts, other._contacts)

    @property
    def table(self) -> _Rows:
        """Structured array, a row per contact: its numbers and names. worst and depth are NaN where there are none."""
        kinds: list[Any] = [
            ("number", "u4"), ("object_a", "u4"), ("object_b", "u4"), ("name_a", "O"), ("name_b", "O"), ("folded", "?"),
            ("pierces", "?"), ("from_start", "?"), ("healed", "?"), ("first_time", "f8"), ("last_time", "f8"), ("pairs", "u8"),
            ("worst", "f8"), ("depth", "f8"), ("at_least", "?"), ("touching", "?"), ("triangles", "u8"),
            ("curve_length", "f8"), ("point", "f8", 3), ("normal", "f8", 3),
        ]  # fmt: skip
        rows = np.zeros(len(self), kinds)
        for k, c in enumerate(self):
            a, b = c.sides
            worst = c.worst_frame
            triangles, length = (0, 0.0) if worst is None else (worst["triangles"], worst["curve_length"])
            rows[k] = (
                c.number, a.object, b.object, a.name, b.name, c.folded, c.pierces, c.from_start, c.healed, c.first_time,
                c.last_time, c.pairs, _or_nan(c.worst), _or_nan(c.depth), c.at_least, c.touching, triangles, length,
                c.point, c.normal,
            )  # fmt: skip
        return rows

    @property
    def frames(self) -> _Rows:
        """Structured array, a row per contact and frame in which it crosses: number, and Contact.frames."""
        rows = np.zeros(sum(len(c.frames) for c in self), [("number", "u4"), *_FRAME])
        rows["number"] = np.repeat([c.number for c in self], [len(c.frames) for c in self])
        for name, *_ in _FRAME if len(rows) else ():
            rows[name] = np.concatenate([c.frames[name] for c in self])
        return rows

    def to_pandas(self) -> Any:
        """The table as a pandas.DataFrame, indexed by number; point_x, point_y and so on are columns of their own."""
        import pandas

        table = self.table
        columns: dict[str, NDArray[Any]] = {}
        for name in table.dtype.names or ():
            if table[name].ndim == 1:
                columns[name] = table[name]
            else:
                columns |= {f"{name}_{axis}": table[name][:, k] for k, axis in enumerate("xyz")}
        return pandas.DataFrame(columns).set_index("number")

    def __repr__(self) -> str:
        lines = [self._title(), text_table(*self._cells())] if self._contacts else [self._title()]
        if len(self) > _SHOWN:
            lines.append(f"and {len(self) - _SHOWN:,} more")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        more = f"<p>and {len(self) - _SHOWN:,} more</p>" if len(self) > _SHOWN else ""
        table = html_table(*self._cells()) if self._contacts else ""
        return f"<p>{html.escape(self._title())}</p>{table}{more}"

    def _title(self) -> str:
        title = f"{many(len(self), 'contact')}, the worst first" if self._contacts else "no contacts"
        if self.unknown_frames:
            title += f"; of {many(self.unknown_frames, 'frame')} it is not known which triangles cross"
        if self.unlisted_pairs:
            title += f"; {many(self.unlisted_pairs, 'pair')} not listed (max_listed), so in no contact"
        return f"{title}:" if self._contacts else title

    def _cells(self) -> tuple[list[str], list[list[str]]]:
        """Header and rows of what is shown. Sides are named only where names differ."""
        named = len({side.name for c in self for side in c.sides}) > 1
        unit = f" ({self.unit})" if self.unit else ""
        header = ["#", "between", "at", "frames", "worst", "triangles", f"depth{unit}", f"curve{unit}", ""]
        touches = "touches; not known whether it crosses" if self.unknown_frames else "touches"
        rows = [_cells_of(c, touches) for c in self._contacts[:_SHOWN]]
        if not named:
            header, rows = _without_second(header), [_without_second(row) for row in rows]
        return header, rows


def _without_second(cells: list[str]) -> list[str]:
    return cells[:1] + cells[2:]


def _cells_of(c: Contact, touches: str) -> list[str]:
    worst = c.worst_frame
    notes = ["from the start"] * c.from_start + ["folded"] * c.folded
    begin = [str(c.number), c.between, f"({', '.join(f'{x:.3g}' for x in c.point)})"]
    if worst is None:
        notes.insert(0, f"{'pierces' if c.pierces else touches}: {many(c.pairs, 'pair')}")
        return [*begin, _when(c).partition(" ")[2], "-", "-", "-", "-", ", ".join(notes)]
    notes += ["pierces"] * c.pierces
    depth = "-" if c.depth is None else f"{c.depth:.3g}"
    return [
        *begin, _when(c).partition(" ")[2], f"{c.worst:g}", f"{worst['triangles']:,}", depth,
        f"{worst['curve_length']:.3g}", ", ".join(notes),
    ]  # fmt: skip


def _when(c: Contact) -> str:
    """'frames 3-12', or 'times 3.2-3.9' of a contact that only touches."""
    first, last = (c.frames["time"][0], c.frames["time"][-1]) if len(c.frames) else (c.first_time, c.last_time)
    noun = "frame" if len(c.frames) else "time"
    return f"{noun} {first:.6g}" if first == last else f"{noun}s {first:.6g}-{last:.6g}"


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else value


def _same_fields(a: Any, b: Any) -> bool:
    return type(a) is type(b) and all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))


def find_contacts(
    objects: Hierarchy | Model | Sequence[Hierarchy | Model],
    frames: Iterable[ArrayLike | Sequence[ArrayLike]],
    *,
    parts: _Parts = None,
    filter: PairFilter | None = None,
    **settings: Unpack[_StepSettings],
) -> Iterator[Contact]:
    """Checks frames one after the other, and yields each contact when it has ended.

    objects: a Hierarchy, a Model, or a list of them. frames: the positions of each frame, V x 3, or a list of one array
    per object; any iterable, such as a Motion or a generator, which is read frame by frame. parts, filter and settings: as for
    ContactFinder, which does the work for those who have frames at times of their own. Memory is that of the meshes, one
    step and the contacts that have not ended.
    """
    finder = ContactFinder(objects, parts=parts, filter=filter, **settings)
    for x in frames:
        yield from finder.add(x)
    yield from finder.finish()
