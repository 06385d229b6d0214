"""Finds and runs the program foldproof, and reads its answer."""

import dataclasses
import json
import os
import pathlib
import platform
import re
import shutil
import subprocess
import time

import numpy as np

from .problem import Problem
from .progress import Progress


ERRORS = "errors.txt"  # what a program says, in the folder of its files
HERE = pathlib.Path(__file__).parent
# What comes with the add-on, by system and processor as Python names them.
BUNDLED = {
    ("Linux", "x86_64"): HERE / "linux-x64" / "foldproof",
    ("Windows", "AMD64"): HERE / "windows-x64" / "foldproof.exe",
}


def find(path):
    """The program at `path`; if that is empty, the one that came with the add-on, or else the one in PATH."""
    if path:
        if os.path.isfile(path) and os.access(path, os.X_OK):
            return path
        raise Problem(f"'{path}' is not a program: correct it in Preferences > Add-ons > Foldproof")
    bundled = BUNDLED.get((platform.system(), platform.machine()))
    if bundled and bundled.is_file():
        _make_executable(bundled)
        return str(bundled)
    found = shutil.which("foldproof")
    if found:
        return found
    raise Problem(
        "The program foldproof was not found: install it, or say where it is in Preferences > Add-ons > Foldproof"
    )


def _make_executable(program):
    """What Blender unpacks from a zip cannot be run."""
    if os.access(program, os.X_OK):
        return
    try:
        for file in (*program.parent.glob("lib/*"), program):  # this last, as it says that all are done
            file.chmod(0o755)
    except OSError as error:
        raise Problem(
            f"{error.filename} cannot be made executable: {error.strerror}; copy its folder to where it can, and say where"
            " that is in Preferences > Add-ons > Foldproof"
        ) from error


def run(arguments, folder, text):
    """Runs the program and yields Progress; closing the generator ends the program. Returns its exit code, 0 or 1."""
    with open(folder / ERRORS, "wb") as stream:
        try:
            process = subprocess.Popen(
                arguments, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=stream, cwd=folder,
                env=dict(os.environ, FOLDPROOF_PROGRESS="lines"),
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        except OSError as error:
            raise Problem(f"{arguments[0]} cannot be started: {error.strerror}") from error
    begin = time.monotonic()
    try:
        while process.poll() is None:
            seconds = int(time.monotonic() - begin)
            share, left = _progress(folder)
            if share is None:
                yield Progress(0, f"{text}, {seconds // 60}:{seconds % 60:02}", needs_scene=False)
            else:
                yield Progress(share, f"{text}: {100 * share:.0f} %{left and f', {left} left'}", needs_scene=False)
    finally:
        if process.poll() is None:
            process.kill()  # it never leaves an incomplete report
        process.wait()
    if process.returncode not in (0, 1):
        raise Problem(_last_error(folder) or f"{arguments[0]} ended with code {process.returncode} and no message")
    return process.returncode


# Such as "37% repairing, 0:20 left" and "reading body.npz, 0:03".
_PROGRESS = re.compile(r"(\d+)% .*?(?:, (\d+:\d\d) left)?|.*, \d+:\d\d")


def _lines(folder):
    """The last lines that the program has written."""
    with open(folder / ERRORS, "rb") as stream:
        stream.seek(max(0, os.fstat(stream.fileno()).st_size - 4096))
        return stream.read().decode(errors="replace").strip().splitlines() or [""]


def _progress(folder):
    """The share that is done, None if it is not known, and the time that is left, if it is known."""
    found = _PROGRESS.fullmatch(_lines(folder)[-1])
    return (int(found[1]) / 100, found[2] or "") if found and found[1] else (None, "")


def _last_error(folder):
    return next((line for line in reversed(_lines(folder)) if not _PROGRESS.fullmatch(line)), "")


class _Triangles:
    """Finds the triangles of an object that collide, including those around colliding vertices and edges."""

    def __init__(self, triangles, vertex_count):
        self._triangles = triangles
        self._count = vertex_count
        pairs = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).astype(np.int64)
        self._edges = pairs[..., 0] * vertex_count + pairs[..., 1]

    def around(self, faces, vertices, edges):
        marked = np.zeros(len(self._triangles), bool)
        marked[faces] = True
        hit = np.zeros(self._count, bool)
        hit[vertices] = True
        marked |= hit[self._triangles].any(axis=1)
        if edges:
            ends = np.array(edges, np.int64)
            marked |= np.isin(self._edges, ends[:, 0] * self._count + ends[:, 1]).any(axis=1)
        return np.flatnonzero(marked)


@dataclasses.dataclass
class Answer:
    verdict: list  # texts and, in turn, poses
    contacts: list  # as in the report
    unknown_frames: int  # of which it is not known what crosses
    inside: list  # per pose: triangles of each object that cross or are inside; None where that is not known
    meeting: list  # (step, triangles of each object that meet others in it), only steps with any


def read_report(path):
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        said = _last_error(path.parent)
        raise Problem(
            f"The program gave no answer{said and f' ({said})'}: see in Preferences > Add-ons > Foldproof that it is foldproof"
        ) from None
    if "verdict" not in report:
        raise Problem(
            "The program foldproof is too old for this add-on: install its version, or say where that is in"
            " Preferences > Add-ons > Foldproof"
        )
    return report


def read_answer(path, sampled):
    report = read_report(path)
    objects = [_Triangles(each.merged[each.triangles], each.vertex_count) for each in sampled]
    start = report.get("start")  # none with --static
    return Answer(
        report["verdict"]["parts"],
        report["contacts"],
        report["totals"]["contacts"]["unknown_frames"],
        [each["inside"] for each in ([start] if start else []) + report["steps"]],
        [(number, _meeting(step["pairs"], objects)) for number, step in enumerate(report["steps"]) if sum(step["collisions"].values())],
    )


def _meeting(pairs, objects):
    faces, vertices, edges = ([[] for _ in objects] for _ in range(3))
    for vertex_object, vertex, face_object, face, _ in pairs["vf"]:
        vertices[vertex_object].append(vertex)
        faces[face_object].append(face)
    for a, a0, a1, b, b0, b1, _ in pairs["ee"]:
        edges[a].append((a0, a1))
        edges[b].append((b0, b1))
    return [each.around(*found) for each, *found in zip(objects, faces, vertices, edges)]
