"""tools/reproduce: its generated meshes, and all of it on coarse ones."""
import os
import pathlib
import re
import runpy
import subprocess
import sys

import numpy as np
import pytest
from conftest import rolled

import foldproof

SCRIPT = pathlib.Path(__file__).parents[2] / "tools" / "reproduce"


@pytest.mark.parametrize("name", ["cylinder", "creature"])
def test_generated_meshes_are_closed_and_meet_themselves(name):
    subject = runpy.run_path(str(SCRIPT))[name](True)
    edges = [(int(t[k]), int(t[(k + 1) % 3])) for t in subject.triangles for k in range(3)]
    assert len(set(edges)) == len(edges) and {(b, a) for a, b in edges} == set(edges)
    corners = np.moveaxis(subject.poses[0][subject.triangles], 1, 0)
    assert np.einsum("ni,ni->", corners[0], np.cross(corners[1], corners[2])) > 0  # outside out
    checker = foldproof.StepChecker(foldproof.Hierarchy(subject.triangles, subject.poses[0]))
    assert checker.check_static(subject.poses[0]).clean and checker.check_static(subject.motion[0]).clean
    assert not checker.check_static(subject.motion[-1]).clean


@pytest.fixture
def reproduce(tmp_path):
    program = os.environ.get("FOLDPROOF_PROGRAM")
    if not program or not pathlib.Path(program).exists():
        pytest.skip("FOLDPROOF_PROGRAM does not name the program")

    def run(*arguments):
        command = [sys.executable, SCRIPT, "--quick", "--program", program, *arguments]
        module = {**os.environ, "PYTHONPATH": str(pathlib.Path(foldproof.__file__).parents[1])}
        return subprocess.run(command, cwd=tmp_path, env=module, capture_output=True, text=True, timeout=120)

    return run


def rows(page, mode):
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines() if line.startswith("| " + mode)]


def test_pictures_and_tables(reproduce, tmp_path, triangles):
    (tmp_path / "data/lion-poses").mkdir(parents=True)
    for k, turn in enumerate([0.5, 2, 4, 7, 3, 9, 5]):
        foldproof.write_motion(tmp_path / f"data/lion-poses/{k}.obj", foldproof.Motion(triangles, rolled(turn)))
    done = reproduce("-o", "out", "--data", "data", "--threads", "1")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "out/index.md tells what came out\n"
    page = (tmp_path / "out/index.md").read_text()
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]*)\)", page)
    assert all((tmp_path / "out" / name).read_bytes().startswith(b"\x89PNG") for name in pictures)
    for name in ("creature-key-points", "cylinder-pose-0", "cylinder-predicted", "creature-bent", "creature-contact",
                 "creature-from-key-points", "direction-one-plane", "lion-contact"):
        assert f"{name}.png" in pictures
    for part in ("(Fig. 2 and 3)", "(Fig. 9)", "Generated", "--quick", "### lion"):
        assert part in page
    assert "### hand" not in page
    assert foldproof.load(tmp_path / "out/creature.model").learned
    # As it is and in the subspace, for three meshes. Collisions there are, and no proven mode misses one.
    assert len(rows(page, "plain hierarchies")) == 6 and len(rows(page, "reduced")) == 3
    for mode in ("plain hierarchies", "certificates, no model", "certificates, model", "reduced"):
        for row in rows(page, mode):
            assert row[4] != "0" and row[5:] == ["0", "0"], row
    assert all(float(row[3].rstrip("%")) > 50 for row in rows(page, "certificates, model")[:4])
    assert len(rows(page, "paper")) >= 6 and all("(statistical)" in row[0] for row in rows(page, "paper"))


def test_mistakes_are_explained(reproduce, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "bad/lion-poses").mkdir(parents=True)
    (tmp_path / "bad/lion-poses/a.obj").write_text("f 1 2 3\n")
    (tmp_path / "file").write_text("")
    for arguments, problem in ((["-o", "a", "--data", "empty"], "empty: holds nothing that is known"),
                               (["-o", "a", "--data", "bad"], "a.obj"), (["-o", "file/out"], "file/out"),
                               (["-o", "a", "--threads", "-3"], "-3 is not between")):
        done = reproduce(*arguments)
        assert done.returncode == 1 and problem in done.stderr and done.stderr.count("\n") == 1, done.stderr
