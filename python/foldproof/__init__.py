"""Finds every collision of deforming triangle meshes, and proves large parts collision-free.

Arrays of positions are V x 3 (one frame) or F x V x 3 (frames), float64, in mesh units; float64 in C order is used in
place, everything else is converted once. Triangles are T x 3 vertex ids. Functions report errors with foldproof.Error,
whose text says where the problem is, what it is and how to fix it.
"""

from ._core import *  # noqa: F403
from ._core import __version__

__all__ = [name for name in dir() if not name.startswith("_")] + ["__version__"]
