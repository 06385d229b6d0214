"""The page of the program `foldproof view`, in a notebook or a browser."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import weakref
from typing import TYPE_CHECKING

from ._core import Motion, write_motion
from ._errors import Error, FileMissingError

if TYPE_CHECKING:
    from ._core import _Path


class Page:
    """A page that the program serves to this machine until it is closed, collected, or Python ends.

    url: its address. As a context manager it is closed at the end.
    """

    __module__ = "foldproof"

    def __init__(self, process: subprocess.Popen[str], folder: tempfile.TemporaryDirectory[str]) -> None:
        self._process = process
        self._close = weakref.finalize(self, _end, process, folder)
        assert process.stdout is not None and process.stderr is not None
        self.url = process.stdout.readline().partition(" ")[0]
        if not self.url:
            said = process.stderr.read().strip().removeprefix("foldproof: ")
            self.close()
            where, _, rest = said.partition(": ")
            problem, _, remedy = rest.rpartition("; ")
            raise Error(where or "view", problem or "ended without a message", remedy or "see foldproof view --help")

    def close(self) -> None:
        """Ends the program. The page in the browser stops working."""
        self._close()

    def wait(self) -> None:
        """Returns when the program ends, or closes the page on Ctrl-C. For scripts, which would end and close it."""
        try:
            self._process.wait()
        except KeyboardInterrupt:
            self.close()

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<foldproof.Page {self.url if self._is_served() else 'closed'}>"

    def _is_served(self) -> bool:
        return self._close.alive and self._process.poll() is None

    def _repr_html_(self) -> str:
        if not self._is_served():
            return repr(self).replace("<", "&lt;")
        return (
            f'<iframe src="{self.url}" width="100%" height="640" style="border: 0" allowfullscreen></iframe>'
            f'<a href="{self.url}" target="_blank">{self.url}</a>'
        )


def view(*motions: Motion | _Path, program: _Path = "foldproof", options: tuple[str, ...] = ()) -> Page:
    """Shows motions, their collisions and contacts on a page, by the program `foldproof view`: returns a Page.

    motions: Motion or path, one or several that move together. program: its path, or its name to look for in PATH.
    options: for the program, such as ('--thickness', '0.01'). The browser opens where there is a display; a notebook
    shows the page itself, if it runs on the machine of the browser. A script keeps the page open with .wait(). Error: the program is not there or refuses a motion.
    """
    found = shutil.which(os.fsdecode(program))
    if found is None:
        raise FileMissingError(os.fsdecode(program), "is not a program in PATH", "install foldproof, or name it: program=")
    folder = tempfile.TemporaryDirectory(prefix="foldproof-")
    paths: list[str] = []
    for motion in motions:
        if isinstance(motion, Motion):
            paths.append(os.path.join(folder.name, f"motion{len(paths)}.npz"))
            write_motion(paths[-1], motion)
        else:
            paths.append(os.fsdecode(motion))
    in_notebook = ("--no-browser",) if "ipykernel" in sys.modules and "--no-browser" not in options else ()
    command = [found, "view", *paths, *options, *in_notebook]
    process = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,  # a terminal's Ctrl-C is for Python's other work
    )  # fmt: skip
    try:
        return Page(process, folder)
    except Error as error:
        if error.where in paths and not os.path.exists(error.where):
            raise FileMissingError(error.where, error.problem, error.remedy) from None
        raise


def _end(process: subprocess.Popen[str], folder: tempfile.TemporaryDirectory[str]) -> None:
    process.terminate()
    process.wait()
    for pipe in (process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()
    folder.cleanup()
