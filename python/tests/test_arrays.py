"""Arrays in and out: in place where they can be, refused with our words where they cannot, alive as long as needed."""
import base64
import gc
import json
import pathlib
import pickle

import numpy as np
import pytest

import foldproof


def resident():
    """MB of memory in use."""
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6


def test_float64_in_c_order_is_used_in_place(triangles):
    # Sees what is written into the caller's array after the motion was made.
    frames = np.zeros((2, 305, 3))
    motion = foldproof.Motion(triangles, frames)
    frames[1, 7] = [1, 2, 3]
    assert np.array_equal(motion[1][7], [1, 2, 3])


def test_a_large_array_costs_no_memory(triangles):
    frames = np.ones((20_000, 305, 3))  # 146 MB
    before = resident()
    motion = foldproof.Motion(triangles, frames)
    assert motion[19_999].shape == (305, 3)
    assert resident() - before < 50


@pytest.mark.parametrize("convert", [
    lambda x: x.astype(np.float32),
    lambda x: np.asfortranarray(x),
    lambda x: np.repeat(x, 2, axis=0)[::2],
    lambda x: x.astype(">f8"),
    lambda x: x[::-1][::-1],
    lambda x: [x.tolist()],
])
def test_other_layouts_are_converted(triangles, frames, convert):
    checker = foldproof.StepChecker(foldproof.Hierarchy(triangles, frames[0]))
    expected = checker.check(frames[-2], frames[-1])
    found = checker.check(convert(frames[-2]), convert(frames[-1]))
    if getattr(convert(frames[0]), "dtype", None) == np.float32:
        assert len(found.edge_edge) > 0  # rounded, so not quite the same
    else:
        assert np.array_equal(found.vertex_face, expected.vertex_face)


def test_unaligned_memory_is_converted(triangles, frames):
    raw = np.empty(frames[0].nbytes + 1, np.uint8)[1:]
    unaligned = raw.view(np.float64).reshape(frames[0].shape)
    unaligned[:] = frames[0]
    assert not unaligned.flags.aligned
    assert foldproof.Hierarchy(triangles, unaligned).vertex_count == 305


@pytest.mark.parametrize("bad, words", [
    (lambda x: x[:, :2], "x1: has shape (305, 2); give V x 3 with V = 305"),
    (lambda x: x[:-1], "x1: has shape (304, 3); give V x 3 with V = 305"),
    (lambda x: x.ravel(), "x1: has shape (915,); give V x 3 with V = 305"),
    (lambda x: x.astype(complex), "x1: holds complex128, not real numbers; give an array of float64"),
    (lambda x: x.astype(str), "not real numbers; give an array of float64"),
    (lambda x: x > 0, "x1: holds bool, not real numbers; give an array of float64"),
    (lambda x: [x, x], "x1: has 2 arrays for 1 objects; give a list with one array V x 3 per object"),
    (lambda x: np.where(np.arange(3) == 1, np.nan, x), "not finite"),
    (lambda x: np.full_like(x, np.inf), "not finite"),
    (lambda x: np.ma.masked_greater(x, 1), "x1: has masked entries; fill them, for example with filled()"),
    (lambda x: None, "x1: "),
])
def test_bad_positions_are_refused(triangles, frames, bad, words):
    checker = foldproof.StepChecker(foldproof.Hierarchy(triangles, frames[0]))
    with pytest.raises(foldproof.Error) as refused:
        checker.check(frames[0], bad(frames[1]))
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)
    assert checker.check(frames[0], frames[1]) is not None  # goes on


@pytest.mark.parametrize("bad, words", [
    ([[0, 1, -1]], "triangles: row 0 names vertex -1; count vertices from 0"),
    ([[0, 1, 2], [0, 1, 2**32]], "triangles: row 1 names vertex 4294967296"),
    ([[0, 1, 305]], "305"),
    (np.array([[0, 1, 2**64 - 2]], np.uint64), "row 0 names vertex 18446744073709551614"),
    (np.ma.masked_array([[0, 1, 2]], [[True, False, False]]), "triangles: has masked entries"),
    ([[0, 1]], "triangles: have shape (1, 2); give T x 3 vertex ids"),
    ([[0.0, 1, 2]], "triangles: hold float64, not integers"),
    (np.zeros((0, 3), int), "triangles"),
])
def test_bad_triangles_are_refused(frames, bad, words):
    with pytest.raises(foldproof.Error) as refused:
        foldproof.Hierarchy(bad, frames[0])
    assert words in str(refused.value)


def test_masked_entries_are_refused_everywhere(triangles, frames, model):
    masked = np.ma.masked_greater(frames, 1)
    for call in (lambda: foldproof.Motion(triangles, masked), lambda: foldproof.Motion(triangles, masked[0]),
                 lambda: foldproof.Motion.from_arrays(frames, np.ma.masked_equal(triangles, 7)),
                 lambda: model.predict(masked[:, model.key_points]), lambda: model.predict(masked[-1, model.key_points])):
        with pytest.raises(foldproof.Error, match="masked entries"):
            call()
    assert foldproof.Motion(triangles, np.ma.masked_array(frames)) == foldproof.Motion(triangles, frames)


def test_bad_frames_name_frame_and_vertex(triangles, frames):
    frames = frames.copy()
    frames[3, 7, 1] = np.nan
    with pytest.raises(ValueError, match=r"frames\[3, 7, 1\]: is not finite; give finite numbers"):
        foldproof.Motion(triangles, frames)
    changed = np.zeros_like(frames)
    motion = foldproof.Motion(triangles, changed)
    changed[3, 7, 1] = np.inf
    with pytest.raises(foldproof.Error, match="array, frame 3, vertex 7: a coordinate is not finite"):
        foldproof.check(motion)
    with pytest.raises(foldproof.Error, match="give F x V x 3"):
        foldproof.Motion(triangles, frames[:, :, :2])
    with pytest.raises(foldproof.Error, match="frames: are empty"):
        foldproof.Motion(triangles, frames[:0])


def test_errors_have_parts_and_are_value_errors(tmp_path):
    missing = tmp_path / "nowhere.model"
    with pytest.raises(ValueError) as refused:
        foldproof.load(missing)
    error = refused.value
    assert isinstance(error, foldproof.Error)
    assert error.where == str(missing) and "does not exist" in error.problem and error.remedy
    assert str(error) == f"{error.where}: {error.problem}; {error.remedy}"


def test_a_file_name_need_not_be_text(tmp_path):
    with pytest.raises(foldproof.Error, match="xff"):
        foldproof.load(bytes(tmp_path) + b"/\xff.model")


def test_wrong_calls_are_type_errors(motion, triangles, frames, model):
    checker = foldproof.StepChecker(foldproof.Hierarchy(triangles, frames[0]))
    for call in (lambda: checker.check(frames[0], frames[1], thicknes=1), lambda: foldproof.check(frames),
                 lambda: foldproof.check(motion, thickness="x"), lambda: foldproof.train(motion, modes="x"),
                 lambda: foldproof.train(motion, mode=1), lambda: foldproof.StepChecker(frames),
                 lambda: foldproof.check(motion, frames=1.5), lambda: foldproof.check(motion, models=[motion])):
        with pytest.raises(TypeError):
            call()
    for call in (lambda: foldproof.StepChecker([]), lambda: foldproof.check([]), lambda: foldproof.train([]),
                 lambda: foldproof.check(motion, thickness=-1), lambda: foldproof.check(motion, frames=slice(5, 5)),
                 lambda: foldproof.check(motion, models=[model, model]), lambda: foldproof.set_threads(-1),
                 lambda: foldproof.check(motion, reports="a.doc"), lambda: foldproof.check(motion, mode="guess"),
                 lambda: foldproof.train(motion, energy=2.0), lambda: foldproof.open_motion("a.npz", fps=0),
                 lambda: foldproof.ReducedShape(model, clearance=-1), lambda: foldproof.open_motion()):
        with pytest.raises(foldproof.Error):
            call()
    with pytest.raises(IndexError):
        motion[len(motion)]
    with pytest.raises(IndexError):
        foldproof.ReducedShape(model).radius(99)


@pytest.mark.parametrize("name, call", [
    ("substeps", lambda motion, n: foldproof.check(motion, substeps=n)),
    ("max_listed", lambda motion, n: foldproof.check(motion, max_listed=n)),
    ("modes", lambda motion, n: foldproof.train(motion, modes=n)),
    ("references", lambda motion, n: foldproof.train(motion, references=n)),
    ("random_poses", lambda motion, n: foldproof.train(motion, random_poses=n)),
    ("leaf_triangles", lambda motion, n: foldproof.Hierarchy(motion.triangles, motion[0], n)),
    ("leaf_triangles", lambda motion, n: foldproof.CollisionMesh(motion[0], leaf_triangles=n)),
])
def test_whole_numbers_out_of_range_are_named(motion, name, call):
    for number in (-1, 2**64, *[0] * (name == "substeps"), *[2**32] * (name != "max_listed")):
        with pytest.raises(foldproof.Error, match=f"^{name}: is {number}; give a whole number from [01] to [0-9]+$"):
            call(motion, number)
    for wrong in (1.5, "1", None):
        with pytest.raises(TypeError, match=f"{name}: expected an int"):
            call(motion, wrong)


def test_messages_name_arguments(motion, tmp_path):
    tripled = foldproof.Motion(motion.triangles, motion[0])
    for call, text in (
        (lambda: foldproof.check(motion, frames="0:0"), "frames: selects 0 of 12 frames"),
        (lambda: foldproof.check(motion, frames=99), "frames: selects 0 of 12 frames"),
        (lambda: foldproof.check(motion, frames="--frames"), "frames: '--frames' is not A:B"),
        (lambda: foldproof.check(motion, within=False), "or leave within=False out; .* unless separate=True$"),
        (lambda: foldproof.check(motion, mode="paper"), "; give models= one trained on at least 3"),
        (lambda: foldproof.check(tripled, steps_only=True), "; check it without steps_only=True: "),
        (lambda: foldproof.check(motion, reports=tmp_path / "%x.ply"), "reports: '.*%x.ply' has a '%'"),
        (lambda: foldproof.check(motion, reports=""), "path: is empty; name a file"),
        (lambda: foldproof.open_motion(""), "path: is empty; name a file"),
    ):
        with pytest.raises(foldproof.Error, match=text) as refused:
            call()
        assert not refused.value.where.startswith("--")
    with pytest.raises(foldproof.FileMissingError) as missing:
        foldproof.open_motion(tmp_path / "a --weld b.npz")
    assert missing.value.filename == str(tmp_path / "a --weld b.npz")


def test_without_learning_shapes_are_refused(triangles, frames):
    plain = foldproof.train(foldproof.Motion(triangles, frames[:3]), learn=False)
    assert not plain.learned
    with pytest.raises(foldproof.Error, match="shapes: not requested; train it again with learn=True, from at least 3"):
        plain.basis
    for call in (lambda: plain.mean, lambda: plain.predict(np.zeros((1, 3))), lambda: foldproof.ReducedShape(plain)):
        with pytest.raises(foldproof.Error, match="has learned no shapes"):
            call()


def test_views_outlive_their_owners(triangles, frames):
    def views():
        motion = foldproof.Motion(triangles, frames.copy())
        hierarchy = foldproof.Hierarchy(triangles, frames[0])
        model = foldproof.train(foldproof.Motion(triangles, frames[:4]))
        step = foldproof.StepChecker(model).check(frames[-2], frames[-1], explain=True)
        whole = foldproof.check(motion)
        kept = [motion.triangles, hierarchy.triangles, hierarchy.edges, model.mean, model.basis, model.key_points,
                model.hierarchy.triangles, model.coordinates, step.vertex_face, step.edge_edge, whole.steps,
                whole.edge_edge, step.explanation[0]["level"], motion[3], model.predict(frames[:2, model.key_points])]
        return kept, [x.copy() for x in kept]

    def trample():
        gc.collect()
        return [np.full(1000, 255, np.uint8) for _ in range(2000)]

    kept, before = views()
    trample()
    assert all(np.array_equal(x, y) for x, y in zip(kept, before))
    assert np.array_equal(kept[0], triangles)


def test_views_cannot_be_written(motion, model):
    for view in (motion.triangles, model.mean, model.basis, foldproof.check(motion).vertex_face):
        with pytest.raises(ValueError):
            view[0] = 0


def test_motion_is_a_sequence(motion, frames):
    assert len(motion) == len(frames) and motion.vertex_count == 305 and motion.name == "array"
    assert np.array_equal(np.stack(list(motion)), frames) and np.array_equal(motion[-1], frames[-1])
    assert motion[0].flags.writeable


def test_files_come_back(motion, frames, tmp_path):
    foldproof.write_motion(tmp_path / "a.npz", motion)
    read = foldproof.open_motion(tmp_path / "a.npz")
    assert np.array_equal(np.stack(list(read)), frames) and np.array_equal(read.triangles, motion.triangles)
    assert len(foldproof.open_motions(tmp_path / "a.npz", str(tmp_path / "a.npz"))) == 2
    with pytest.raises(foldproof.Error, match="are 2 motions"):
        foldproof.open_motion(tmp_path / "a.npz", tmp_path / "a.npz")


def test_motions_of_one_frame_can_stand_still(motion, tmp_path):
    paths = [tmp_path / "floor.obj", tmp_path / "roll.npz"]
    foldproof.write_motion(paths[0], motion[:1])
    foldproof.write_motion(paths[1], motion)
    assert [len(read) for read in foldproof.open_motions(*paths)] == [1, 12]
    floor, roll = foldproof.open_motions(*paths, still=True)
    assert len(floor) == len(roll) == 12 and np.array_equal(floor[11], floor[0]) and roll == motion
    assert foldproof.check([floor, roll], within=False).steps.shape == (11,)


def test_numbered_meshes_are_frames_unless_separate(motion, frames, tmp_path):
    paths = [tmp_path / "pose1.obj", tmp_path / "pose2.obj"]
    for k, path in enumerate(paths):
        foldproof.write_motion(path, motion[k:k + 1])
    assert [len(read) for read in foldproof.open_motions(*paths)] == [2]
    separate = foldproof.open_motions(*paths, separate=True)
    assert [len(read) for read in separate] == [1, 1] and np.array_equal(separate[1][0], frames[1])


def test_unknown_keywords_suggest_what_was_meant(motion, triangles, frames):
    checker = foldproof.StepChecker(foldproof.Hierarchy(triangles, frames[0]))
    for call, meant in ((lambda: foldproof.check(motion, thicknes=1), "thickness"),
                        (lambda: foldproof.check(motion, step_only=True), "steps_only"),
                        (lambda: checker.check(frames[0], frames[1], tolerence=1), "tolerance"),
                        (lambda: foldproof.train(motion, keypoints=0.1), "key_points")):
        with pytest.raises(TypeError, match=f"did you mean '{meant}'"):
            call()
    with pytest.raises(TypeError, match="'color' is not a setting of a check$"):
        foldproof.check(motion, color=1)


def test_frames_that_look_like_bodies_are_asked_for(tmp_path):
    triangles, tetrahedron = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)], np.vstack([np.zeros(3), np.eye(3)])
    for name, x in (("body1", 0), ("body2", 0.5), ("left", 0), ("right", 0.1)):
        folder = tmp_path / ("bodies" if name[-1].isdigit() else "lr")
        folder.mkdir(exist_ok=True)
        foldproof.write_motion(folder / f"{name}.obj", foldproof.Motion(triangles, tetrahedron + [x, 0, 0]))
    bodies, lr = tmp_path / "bodies", tmp_path / "lr"
    with pytest.raises(foldproof.Error, match="2 bodies: .*; say which it is: sequence=True or separate=True$"):
        foldproof.open_motion(bodies)
    assert [len(read) for read in foldproof.open_motions(bodies, separate=True)] == [1, 1]
    frames = foldproof.open_motion(bodies, sequence=True)
    assert len(frames) == 2 and frames.taken_as == pickle.loads(pickle.dumps(frames)).taken_as == "2 frames of one mesh"
    assert "0 collisions in 0 of 1 step between 2 frames of one mesh;" in repr(foldproof.check(frames))
    assert [read.taken_as for read in foldproof.open_motions(lr)] == ["", ""]
    assert len(foldproof.open_motion(lr, sequence=True)) == 2
    with pytest.raises(foldproof.Error, match="are 2 motions; give one, sequence=True if they are its frames"):
        foldproof.open_motion(lr)
    with pytest.raises(foldproof.Error, match="sequence: does not go with separate"):
        foldproof.open_motions(lr, sequence=True, separate=True)


def test_a_clip_of_a_gltf_is_chosen_by_name(tmp_path):
    numbers = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 0, 1, 1, 1, 2, 2, 2], dtype="<f4").tobytes()
    views = [(0, 3, "VEC3"), (36, 2, "SCALAR"), (36, 3, "SCALAR"), (48, 2, "VEC3"), (48, 3, "VEC3")]
    clip = lambda times, values: {"samplers": [{"input": times, "output": values}],
                                  "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}
    (tmp_path / "a.gltf").write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [{"name": "walk", **clip(1, 3)}, {"name": "run", **clip(2, 4)}],
        "accessors": [{"bufferView": k, "componentType": 5126, "count": count, "type": kind}
                      for k, (_, count, kind) in enumerate(views)],
        "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": 4 * count * (3 if kind == "VEC3" else 1)}
                        for start, count, kind in views],
        "buffers": [{"byteLength": len(numbers),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(numbers).decode()}]}))
    longest, walk = foldproof.open_motion(tmp_path / "a.gltf", fps=1), foldproof.open_motion(tmp_path / "a.gltf", fps=1, clip="walk")
    assert longest.clips == walk.clips == ["walk", "run"] and (len(longest), len(walk)) == (3, 2)
    assert longest.taken_as == "clip 'run', the longest of 2" and walk.taken_as == "clip 'walk'"
    assert "in clip 'run', the longest of 2" in repr(foldproof.check(longest))
    with pytest.raises(foldproof.Error, match="has no clip 'wlk'; did you mean 'walk'"):
        foldproof.open_motions(tmp_path / "a.gltf", clip="wlk")
