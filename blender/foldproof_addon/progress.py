"""The progress of a job."""

from typing import NamedTuple


class Progress(NamedTuple):
    fraction: float
    text: str
    needs_scene: bool  # the user must not change the scene now
