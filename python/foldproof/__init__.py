"""Finds every collision of deforming triangle meshes, and proves large parts collision-free.

Arrays of positions are V x 3 (one frame) or F x V x 3 (frames), float64, in mesh units; float64 in C order is used in
place, everything else is converted once. Triangles are T x 3 vertex ids. Functions report errors with foldproof.Error,
whose text says where the problem is, what it is and how to fix it.
"""

from ._checks import CheckResult, check
from ._classes import complete_classes
from ._contacts import Contact, Contacts, ContactSide, find_contacts
from ._core import (
    CLOSE_PAIR_KINDS,
    HIT,
    REASONS,
    UNDECIDED,
    Candidates,
    CollisionMesh,
    ContactChecker,
    ContactFinder,
    Hierarchy,
    Model,
    Motion,
    PairFilter,
    ReducedChecker,
    ReducedShape,
    StaticResult,
    StepChecker,
    StepResult,
    __version__,
    build_info,
    ignore_all,
    ignore_fixed,
    ignore_length,
    ignore_rings,
    ignore_sewn,
    ignore_touching,
    load,
    open_motion,
    open_motions,
    set_threads,
    step_towards,
    train,
    write_motion,
)
from ._errors import Error, FileError, FileMissingError
from ._page import Page, view
from ._repair import RepairResult, repair

__all__ = [
    "CLOSE_PAIR_KINDS",
    "HIT",
    "REASONS",
    "UNDECIDED",
    "Candidates",
    "CheckResult",
    "CollisionMesh",
    "Contact",
    "ContactChecker",
    "ContactFinder",
    "ContactSide",
    "Contacts",
    "Error",
    "FileError",
    "FileMissingError",
    "Hierarchy",
    "Model",
    "Motion",
    "Page",
    "PairFilter",
    "ReducedChecker",
    "ReducedShape",
    "RepairResult",
    "StaticResult",
    "StepChecker",
    "StepResult",
    "__version__",
    "build_info",
    "check",
    "find_contacts",
    "ignore_all",
    "ignore_fixed",
    "ignore_length",
    "ignore_rings",
    "ignore_sewn",
    "ignore_touching",
    "load",
    "open_motion",
    "open_motions",
    "repair",
    "set_threads",
    "step_towards",
    "train",
    "view",
    "write_motion",
]

complete_classes()
del complete_classes
