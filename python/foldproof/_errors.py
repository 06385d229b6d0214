"""Why a file, mesh or argument was refused."""

from __future__ import annotations

import errno
import re

_CONTROLS = dict.fromkeys([*range(32), 127], "?")
# Options of the program, as the library's messages name them, and the arguments that do the same.
_ARGUMENTS = {
    "--between": "within=False", "--clip": "clip=", "--fps": "fps", "--frames": "frames", "--model": "models=",
    "--no-weld": "weld=False", "--ply": "reports", "--points": "points=True", "--separate": "separate=True",
    "--sequence": "sequence=True", "--still-pairs": "still_pairs=True",
    "--steps-only": "steps_only=True", "--weld": "weld=True",
}  # fmt: skip
_OPTION = re.compile(rf"(?<![^ (])({'|'.join(_ARGUMENTS)})(?![\w-])")


def with_arguments(text: str) -> str:
    """A message of the library, with arguments instead of options."""
    return _OPTION.sub(lambda found: _ARGUMENTS[found[0]], text)


class Error(ValueError):
    """Why a file, mesh or argument was refused; its text is one line.

    where: file and place, or argument. problem: what is wrong. remedy: what to do about it.
    """

    __module__ = "foldproof"

    def __init__(self, where: str, problem: str, remedy: str) -> None:
        super().__init__(where, problem, remedy)
        self.where = where
        self.problem = problem
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{self.where}: {self.problem}; {self.remedy}".translate(_CONTROLS)


class FileError(Error, OSError):
    """A file that cannot be opened, read or written; also an OSError, whose filename is `where`."""

    __module__ = "foldproof"

    def __init__(self, where: str, problem: str, remedy: str) -> None:
        super().__init__(where, problem, remedy)
        self.filename = where
        self.strerror = problem


class FileMissingError(FileError, FileNotFoundError):
    """A file or directory that is not there; also a FileNotFoundError."""

    __module__ = "foldproof"

    def __init__(self, where: str, problem: str, remedy: str) -> None:
        super().__init__(where, problem, remedy)
        self.errno = errno.ENOENT
