"""How far a job is."""

from typing import NamedTuple


class Progress(NamedTuple):
    fraction: float
    text: str
    needs_scene: bool  # the user must not change the scene now
