"""What Python gets is what the program says."""
import csv
import json
import pathlib
import re

import numpy as np
import pytest

import foldproof
from conftest import rolling


def rows_of(path):
    with open(path) as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("settings, options", [
    ({}, []),
    ({"thickness": 0.05}, ["--thickness", "0.05"]),
    ({"certificates": False}, ["--no-certificates"]),
    ({"substeps": 3, "frames": slice(2, None, 2)}, ["--substeps", "3", "--frames", "2::2"]),
])
def test_check_is_the_programs(motion, program, tmp_path, settings, options):
    foldproof.write_motion(tmp_path / "roll.npz", motion)
    done = program("check", "roll.npz", "--csv", "roll.csv", "--quiet", *options)
    assert done.returncode == 1, done.stderr
    theirs = rows_of(tmp_path / "roll.csv")
    ours = foldproof.check(motion, **settings)
    assert not ours.clean and ours.collisions == len(theirs) > 100

    steps = {int(s["number"]): s for s in ours.steps}
    mine = {("vf", steps[c["step"]]["frame"], steps[c["step"]]["substep"], c["vertex"], c["face"]): c["toi"]
            for c in ours.vertex_face}
    mine |= {("ee", steps[c["step"]]["frame"], steps[c["step"]]["substep"], *c["a"], *c["b"]): c["toi"]
             for c in ours.edge_edge}
    for row in theirs:
        pair = (row["a0"], row["b0"]) if row["kind"] == "vf" else (row["a0"], row["a1"], row["b0"], row["b1"])
        key = (row["kind"], int(row["frame"]), int(row["substep"]), *map(int, pair))
        assert mine.pop(key) == pytest.approx(float(row["toi"]), abs=1e-12)
    assert not mine


def test_poses_are_the_programs(motion, program, tmp_path):
    foldproof.write_motion(tmp_path / "roll.npz", motion)
    program("check", "roll.npz", "--static", "--csv", "roll.csv", "--quiet")
    theirs = [(int(r["frame"]), int(r["a0"]), int(r["b0"])) for r in rows_of(tmp_path / "roll.csv")]
    ours = foldproof.check(motion, static=True)
    frame = ours.steps["frame"][ours.crossings["step"]]
    mine = list(zip(frame, ours.crossings["triangle_a"], ours.crossings["triangle_b"]))
    assert theirs and sorted(mine) == sorted(theirs)
    assert ours.steps["crossings"].sum() == len(theirs)


def test_what_crosses_from_the_start_is_the_programs(triangles, frames, program, tmp_path):
    # The strip is rolled up so far that it goes through itself, and slanted so that no two edges cross exactly.
    rolled_up = frames[-1] + np.arange(len(frames[-1]))[:, None] // 5 * [0.0, 0.00137, 0.0]
    motion = foldproof.Motion(triangles, np.stack([rolled_up, rolled_up + [0.0, 0.25, 0.0]]))
    foldproof.write_motion(tmp_path / "roll.npz", motion)
    done = program("check", "roll.npz", "--csv", "roll.csv", "--steps-only")
    assert done.returncode == 0 and rows_of(tmp_path / "roll.csv") == [], done.stdout
    done = program("check", "roll.npz", "--csv", "roll.csv")
    theirs = [(int(r["a0"]), int(r["b0"])) for r in rows_of(tmp_path / "roll.csv")]
    assert done.returncode == 1 and theirs

    found = foldproof.check(motion)
    assert not found.clean and found.collisions == 0 and found.starts_crossing == len(theirs)
    mine = list(zip(found.start_crossings["triangle_a"], found.start_crossings["triangle_b"]))
    assert sorted(mine) == sorted(theirs)
    assert repr(found) == (f"<foldproof.CheckResult: 0 collisions in 0 of 1 step, 1 contact; "
                           f"frame 0 starts with {len(theirs)} crossing pairs of triangles>")
    counted = foldproof.check(motion, keep=False)
    assert counted.starts_crossing == len(theirs) and len(counted.start_crossings) == 0

    steps = foldproof.check(motion, steps_only=True)
    assert steps.clean and steps.starts_crossing is None and "was not tested" in repr(steps)
    assert foldproof.check(motion, static=True).starts_crossing is None
    with pytest.raises(foldproof.Error, match="steps_only: does not go with static"):
        foldproof.check(motion, static=True, steps_only=True)

    # A single frame is a motion that stands still.
    assert foldproof.check(motion, frames="1").starts_crossing == len(theirs)
    assert foldproof.check(foldproof.Motion(triangles, frames[:1])).clean


def test_reports_are_written_whole(motion, tmp_path):
    foldproof.check(motion, reports=[tmp_path / "a.json", tmp_path / "a.csv", tmp_path / "a.ply"], keep=False)
    assert all((tmp_path / f"a.{kind}").stat().st_size > 100 for kind in ("json", "csv", "ply"))


def test_checks_that_would_test_nothing_are_refused(motion):
    with pytest.raises(foldproof.Error, match="nothing would be tested"):
        foldproof.check(motion, within=False, between=False)


@pytest.mark.parametrize("setting", [{"thickness": 0.1}, {"tolerance": 0.1}, {"substeps": 2}, {"earliest_only": True}])
def test_frames_alone_take_no_settings_of_steps(motion, setting):
    with pytest.raises(foldproof.Error, match=f"{next(iter(setting))}: does not go with static"):
        foldproof.check(motion, static=True, **setting)
    assert foldproof.check(motion, static=True, thickness=0.0, substeps=1).static


@pytest.mark.parametrize("setting", [{"thickness": 1.0}, {"tolerance": 0.1}, {"earliest_only": True}])
def test_a_pose_takes_no_settings_of_steps(triangles, frames, setting):
    checker = foldproof.StepChecker(foldproof.Hierarchy(triangles, frames[0]))
    with pytest.raises(foldproof.Error, match=f"{next(iter(setting))}: does not go with check_static"):
        checker.check_static(frames[0], **setting)
    assert checker.check_static(frames[0], thickness=0.0).clean


def test_a_statistical_answer_says_so(motion, model, tmp_path):
    found = foldproof.check(motion, models=model, mode="paper", reports=tmp_path / "a.json")
    assert repr(found).startswith(f"<foldproof.CheckResult: STATISTICAL: {found.missed} known misses; {found.collisions:,} col")
    assert found.statistical and found._repr_html_().startswith("<p>STATISTICAL: ")
    assert not foldproof.check(motion, models=model).statistical
    for setting in ({"explain": True}, {"earliest_only": True}, {"certificates": False}, {"reports": tmp_path / "a.csv"},
                    {"reports": [tmp_path / "b.json", tmp_path / "a.ply"]}):
        with pytest.raises(foldproof.Error, match="does not go with mode='paper'"):
            foldproof.check(motion, models=model, mode="paper", **setting)
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


def test_the_text_says_what_was_left_out(motion):
    within, between = "pairs within one mesh were not tested", "pairs of two meshes were not tested"
    for settings, untested in (({}, []), ({"within": False}, [within]), ({"between": False}, [between]),
                               ({"static": True}, ["motion between frames was not tested"]),
                               ({"earliest_only": True}, ["only the earliest pair of each step was looked for"])):
        found = foldproof.check([motion, motion], frames=slice(0, 2), **settings)
        assert found.untested == untested and all(each in repr(found) for each in untested)
        assert found.verdict.endswith(".") and all(each in found.verdict for each in untested if each in (within, between))
    assert foldproof.check(motion, frames=slice(0, 2), between=False).untested == []  # there is no second mesh
    assert "(steps_only=True)" in foldproof.check(motion, frames=slice(0, 2), steps_only=True).verdict


def test_the_text_says_how_many_pairs_contacts_join():
    # Six needles, each of which passes through a triangle of its own between the frames.
    floor, needle = np.array([[-2, -2, 0], [2, -2, 0], [0, 3, 0]]), np.array([[0, 0, 1], [0.1, 0, 1], [0, 0.1, 1]])
    at = [np.concatenate([np.concatenate([floor, needle - [0, 0, down]]) + [10 * k, 0, 0] for k in range(6)]) for down in (0, 2)]
    motion = foldproof.Motion(np.arange(36).reshape(12, 3), at)
    whole, cut = foldproof.check(motion), foldproof.check(motion, max_listed=1)
    assert (whole.untested, len(whole.contacts), whole.contacts.unlisted_pairs) == ([], 6, 0)
    listed = len(cut.vertex_face) + len(cut.edge_edge)
    text = f"contacts join only the {listed} of {whole.collisions} colliding pairs that are listed (max_listed)"
    assert cut.untested == [text] and text in repr(cut) and len(cut.contacts) == 1
    assert cut.contacts[:1].unlisted_pairs == whole.collisions - listed
    assert f"{whole.collisions - listed} pairs not listed (max_listed), so in no contact" in str(cut.contacts)
    assert foldproof.check(motion, max_listed=1, contacts=False).untested == []
    crossing = foldproof.check(foldproof.Motion(motion.triangles, np.stack(at).mean(axis=0)), max_listed=2)
    text = "what crosses is not known in frames with more pairs than max_listed: 1"
    assert crossing.starts_crossing == 6 and crossing.untested[-1] == text and text in repr(crossing)
    assert foldproof.check(motion, frames="0", static=True, max_listed=0).untested == ["motion between frames was not tested"]
    poses = foldproof.check(foldproof.Motion(motion.triangles, np.stack(at).mean(axis=0)), static=True, max_listed=2)
    assert poses.untested[1:] == [text] and poses.contacts.unlisted_pairs == 0


def test_reports_replace_neither_each_other_nor_what_is_read(motion, tmp_path, monkeypatch):
    (tmp_path / "run").mkdir()
    for k in range(3):
        foldproof.write_motion(tmp_path / f"run/fr_{k}.ply", motion[k : k + 1])
    monkeypatch.chdir(tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.ply")}
    numbered, directory = foldproof.open_motion("run/fr_%d.ply"), foldproof.open_motion("run")[1:]
    (tmp_path / "link.ply").symlink_to("run/fr_1.ply")
    for each, reports, error in (
        (numbered, "run/fr_1.ply", "run/fr_1.ply: would write over '.*fr_1.ply', which is read"),
        (directory, ["a.json", "./run/fr_2.ply"], "would write over"),
        (directory, "link.ply", "would write over"),
        (numbered, "run/fr_%03d.ply", "would write over"),
        (numbered, "run/fr_9.ply", "would be a frame of what is read"),
        (directory, "run/worst.ply", "would be a frame of what is read"),
        (motion, ["d.json", "./d.json"], "./d.json: is named for two reports"),
        (motion, ["w%d.ply", "w9.ply"], "w9.ply: is named for two reports"),
    ):
        with pytest.raises(foldproof.Error, match=error):
            foldproof.check(each, reports=reports)
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*.ply") if not path.is_symlink()}
    for _ in range(2):
        foldproof.check(directory, reports=["run/a.json", "w%d.ply", "w.csv"])


def test_a_report_says_how_files_were_read(motion, tmp_path):
    foldproof.write_motion(tmp_path / "roll.npz", motion)
    read = foldproof.open_motion(tmp_path / "roll.npz", fps=60, weld=True)
    foldproof.check(read[1:], reports=tmp_path / "a.json", keep=False)
    settings = json.loads((tmp_path / "a.json").read_text())["settings"]
    assert settings["fps"] == 60 and settings["weld"] is True


def test_step_by_step_is_the_whole_check(motion, triangles, frames):
    checker = foldproof.StepChecker(foldproof.Hierarchy(triangles, frames[0]))
    whole = foldproof.check(motion)
    for k in range(len(frames) - 1):
        step = checker.check(frames[k], frames[k + 1])
        of_whole = whole.vertex_face[whole.vertex_face["step"] == k]
        for field in ("vertex", "face", "toi", "answer"):
            assert np.array_equal(step.vertex_face[field], of_whole[field])
        assert len(step.edge_edge) == whole.steps["edge_edge"][k]
        assert step.clean == (len(step.vertex_face) + len(step.edge_edge) == 0)
        assert step.earliest_toi == whole.steps["earliest_toi"][k]
    assert not step.clean


def test_two_objects(triangles, frames):
    # The same cloth twice, the second above the first and falling through it.
    above, below = frames[0] + [0, 0, 1], frames[0] - [0.013, 0.017, 1]
    one = foldproof.Hierarchy(triangles, frames[0])
    step = foldproof.StepChecker([one, one]).check([frames[0], above], [frames[0], below], within=False)
    assert len(step.vertex_face) > 50
    assert step.search_steps == 1
    assert set(step.vertex_face["vertex_object"]) == {0, 1}
    assert step.colliding_faces(one, 1).mean() > 0.9
    apart = foldproof.StepChecker([one, one]).check([frames[0], above], [frames[0], below], between=False)
    assert apart.clean


def test_colliding_faces_are_those_of_the_checked_mesh(triangles, frames, model):
    hierarchy, smaller = foldproof.Hierarchy(triangles, frames[0]), foldproof.Hierarchy([[0, 1, 2]], np.eye(3))
    checker, shape = foldproof.StepChecker(hierarchy), foldproof.ReducedShape(model)
    p = np.zeros(shape.modes)
    for answer in (checker.check(frames[-2], frames[-1]), checker.check_static(frames[0]),
                   foldproof.ReducedChecker(shape).check(p, p)):
        with pytest.raises(ValueError, match="hierarchy: is not that of object 0"):
            answer.colliding_faces(smaller)
        with pytest.raises(ValueError, match="object: 1 is none of the 1 that were checked"):
            answer.colliding_faces(hierarchy, 1)
        assert answer.colliding_faces(hierarchy).any() == (not answer.clean)


def test_models_change_work_only(triangles, frames, model):
    motion = foldproof.Motion(triangles, rolling(np.linspace(0.3, 9, 8)))
    plain, helped = foldproof.check(motion, certificates=False), foldproof.check(motion, models=model)
    assert np.array_equal(plain.vertex_face, helped.vertex_face) and np.array_equal(plain.edge_edge, helped.edge_edge)
    assert helped.work["leaf_pairs"] < plain.work["leaf_pairs"]
    trained, untrained = foldproof.StepChecker(model), foldproof.StepChecker(model.hierarchy)
    first, second = motion[0], motion[1]
    assert trained.check(first, second).work["leaf_pairs"] < untrained.check(first, second).work["leaf_pairs"]


def test_explanation(triangles, frames, model):
    step = foldproof.StepChecker(model).check(frames[0], frames[1], explain=True)
    reasons = step.explanation[0]["reason"]
    assert reasons.shape == (len(triangles),)
    assert foldproof.REASONS[reasons[0]] == "certified"


def test_training_is_the_programs(triangles, program, tmp_path):
    motion = foldproof.Motion(triangles, rolling(np.linspace(0.2, 3, 8)))
    foldproof.write_motion(tmp_path / "roll.npz", motion)
    assert program("train", "roll.npz", "-o", "theirs.model", "--quiet").returncode == 0
    foldproof.train(foldproof.open_motion(tmp_path / "roll.npz")).save(tmp_path / "ours.model")
    # Poses are named after the file, here with its directory.
    theirs, ours = foldproof.load(tmp_path / "theirs.model"), foldproof.load(tmp_path / "ours.model")
    assert theirs.chart_count == ours.chart_count > 0 and theirs.proven == ours.proven
    assert np.array_equal(theirs.basis, ours.basis) and np.array_equal(theirs.key_points, ours.key_points)
    assert [p["proven"] for p in theirs.poses] == [p["proven"] for p in ours.poses]


def test_prediction_is_the_programs(model, program, tmp_path):
    poses = rolling([0.7, 1.9, 2.6])
    keys = poses[:, model.key_points]
    model.save(tmp_path / "a.model")
    np.savez(tmp_path / "tracks.npz", keypoints=keys)
    assert program("predict", "a.model", "tracks.npz", "-o", "out.npz").returncode == 0
    theirs = np.load(tmp_path / "out.npz")["vertices"]
    ours = model.predict(keys)
    assert ours.shape == poses.shape and np.array_equal(ours, theirs)
    assert np.array_equal(model.predict(keys[1]), ours[1])
    assert np.abs(ours - poses).max() < 0.05 * 60


def test_subspace(model):
    p = model.project(rolling([1.3])[0])
    assert p.shape == model.deviations.shape and model.basis.shape == (len(p), *model.mean.shape)
    shape = model.mean + np.tensordot(p, model.basis, axes=1)
    assert np.allclose(model.reconstruct(p), shape)
    assert model.coordinates.shape == (8, len(p))
    assert model.energy[-1] >= 0.999


def test_radius_is_the_programs(model, program, tmp_path):
    model.save(tmp_path / "a.model")
    done = program("radius", "a.model")
    theirs = next(line.split()[1] for line in done.stdout.splitlines() if line.startswith("mean"))
    shape = foldproof.ReducedShape(model)
    assert shape.radius() == pytest.approx(float(theirs), rel=1e-3) and shape.radius() > 0
    radius, uncertified = shape.certified(at_least=2 * shape.radius())
    assert radius > shape.radius() and len(uncertified) > 0 and uncertified["radius"].max() <= 2 * shape.radius()


def test_reduced_checker_answers_as_the_full_one(model):
    shape = foldproof.ReducedShape(model)
    reduced = foldproof.ReducedChecker([shape, shape])
    full = foldproof.StepChecker([model.hierarchy, model.hierarchy])
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    p0, p1 = 0.3 * model.deviations, -1.5 * model.deviations
    collisions = 0
    for start, end in [([p0, (p0, None, [0, 0, 1])], [p0, (p0, None, [0.013, 0.017, -1])]),  # through it
                       ([p0, (p1, turn, [0, 0, 2])], [p1, (p0, turn, [1, 0, -2])]),
                       ([p0, (p1, turn, [0, 0, 500])], [p1, (p0, turn, [1, 0, 500])])]:
        ours = reduced.check(start, end)
        ends = [[shape.positions(*(p if isinstance(p, tuple) else (p,))) for p in poses] for poses in (start, end)]
        truth = full.check(*ends, tolerance=ours.tolerance)
        assert np.array_equal(ours.vertex_face, truth.vertex_face) and np.array_equal(ours.edge_edge, truth.edge_edge)
        collisions += len(ours.edge_edge)
    assert collisions > 0
    for setting in ({"explain": True}, {"mode": "paper"}):
        with pytest.raises(foldproof.Error, match="does not go with ReducedChecker"):
            reduced.check([p0, p0], [p1, p1], **setting)
    mean = np.zeros(shape.modes)
    assert shape.proven_free(mean, 0.5 * shape.radius() * np.eye(shape.modes)[0] * model.deviations[0]) == "free"
    assert shape.distance(mean) == 0


@pytest.mark.parametrize("document", ["README.md", "docs/python.md"])
def test_documents_tell_the_truth(document, motion, tmp_path, monkeypatch, capsys):
    text = (pathlib.Path(__file__).parents[2] / document).read_text()
    block, = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    for name in ("walk", "run"):
        foldproof.write_motion(tmp_path / f"{name}.npz", motion)
    monkeypatch.chdir(tmp_path)
    exec(block.replace(".glb", ".npz"), {})
    assert str(foldproof.check(motion).collisions) in capsys.readouterr().out.split()
