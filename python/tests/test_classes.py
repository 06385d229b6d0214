"""What classes have beyond their numbers: text, slices, copies, equality, errors, and meshes of other libraries."""
import base64
import json
import os
import pickle
import shutil
import types

import numpy as np
import pytest

import foldproof
from conftest import rolling


def test_slices_are_motions(motion, frames, triangles):
    part = motion[2:8:3]
    assert isinstance(part, foldproof.Motion) and len(part) == 2 and np.array_equal(part.triangles, triangles)
    assert np.array_equal(np.stack(list(motion[::-2])), frames[::-2])
    assert np.array_equal(motion[1:][1:][0], frames[2])
    sliced, ranged = foldproof.check(motion[3:]), foldproof.check(motion, frames="3:")
    assert np.array_equal(sliced.edge_edge, ranged.edge_edge) and sliced.collisions > 0
    with pytest.raises(foldproof.Error, match="slice: selects none of 12 frames"):
        motion[5:5]
    for index in (1.5, "a"):
        with pytest.raises(TypeError):
            motion[index]


def test_copies_are_equal(motion, model, frames):
    copy = pickle.loads(pickle.dumps(motion))
    assert copy == motion and copy is not motion and copy.name == motion.name
    assert motion != motion[1:] and motion != foldproof.Motion(motion.triangles, frames + 1) and motion != 3
    same = pickle.loads(pickle.dumps(model))
    assert same == model and np.array_equal(same.basis, model.basis) and same.chart_count == model.chart_count
    assert model != foldproof.train(foldproof.Motion(motion.triangles, rolling([0.1, 0.2, 0.3])))
    for thing in (motion, model):
        with pytest.raises(TypeError, match="unhashable"):
            hash(thing)


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_only_motions_and_models_are_copied(motion, model, frames, protocol):
    for thing in (motion, model):
        assert pickle.loads(pickle.dumps(thing, protocol)) == thing
    hierarchy, mesh = foldproof.Hierarchy(motion.triangles, frames[0]), foldproof.CollisionMesh(frames[0], faces=motion.triangles)
    checker = foldproof.StepChecker(hierarchy)
    for thing in (hierarchy, checker, checker.check_static(frames[0]), mesh, foldproof.ContactChecker(mesh)):
        with pytest.raises(TypeError, match=f"cannot pickle or copy a foldproof.{type(thing).__name__}"):
            pickle.dumps(thing, protocol)


def test_what_readers_leave_out_is_said_and_copied(motion, tmp_path):
    for k in (0, 2):
        foldproof.write_motion(tmp_path / f"f{k}.obj", motion[k : k + 1])
    read = foldproof.open_motion(tmp_path / "f%d.obj", fps=30, weld=True)
    note = "frame numbers jump from 0 to 2: the step between them was not in the files"
    assert motion.notes == [] and read.notes == read[:1].notes == [note]
    found = foldproof.check(read)
    assert found.notes == [f"{read.name}: {note}"]
    assert note in repr(found) and note in found._repr_html_() and "; " not in repr(foldproof.check(motion)).split("; ", 1)[1]
    copy = pickle.loads(pickle.dumps(read))
    assert copy.notes == [note] and copy.name == read.name
    (tmp_path / "named").mkdir()
    for number, name in enumerate((b"a\xff0.obj", b"b1.obj")):
        shutil.copy(tmp_path / f"f{2 * number}.obj", os.path.join(os.fsencode(tmp_path / "named"), name))
    named = foldproof.open_motion(tmp_path / "named", sequence=True)
    assert "\\xff0.obj is followed by b1.obj" in named.notes[0] and pickle.loads(pickle.dumps(named)).notes == named.notes
    foldproof.check(copy, reports=tmp_path / "a.json")
    settings = json.loads((tmp_path / "a.json").read_text())["settings"]
    assert settings["fps"] == 30 and settings["weld"] is True


def test_seams_are_merged_as_asked(tmp_path):
    square = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
    data = "data:application/octet-stream;base64," + base64.b64encode(square.tobytes()).decode()
    (tmp_path / "a.gltf").write_text(json.dumps({
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": 72, "uri": data}],
        "bufferViews": [{"buffer": 0, "byteLength": 72}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}],
    }))  # fmt: skip
    for weld, corner, seams in ((None, 1, "by_format"), (True, 1, "always"), (False, 3, "never")):
        read = foldproof.open_motion(tmp_path / "a.gltf", weld=weld)
        assert read.vertex_count == 6 and read.triangles[1].tolist() == [corner, 4, 2 if corner == 1 else 5]
        assert read.merged.tolist() == ([0, 1, 2, 1, 4, 2] if corner == 1 else [*range(6)])
        copy = pickle.loads(pickle.dumps(read))
        assert copy == read and copy.notes == read.notes and (copy.merged == read.merged).all()
        found = foldproof.check(read, reports=tmp_path / "a.json")
        settings = json.loads((tmp_path / "a.json").read_text())["settings"]
        assert settings["seams"] == seams and settings["weld"] is (weld is True)
        assert found.clean == (weld is not False)
        if weld is False:
            assert found.notes == [f"{read.name}: 2 of 6 vertices lie exactly where others do, and so triangles touch there; "
                                   "if they are of one surface, check it with weld=True"]
        else:
            assert found.notes == [f"{read.name}: 2 of 6 vertices lie on seams and were merged; what meets there counts as neighbors"]


def test_text(motion, model, triangles, frames):
    assert repr(motion) == "<foldproof.Motion 'array': 12 frames, 305 vertices, 480 triangles>"
    assert "305" in motion._repr_html_() and "<table>" in motion._repr_html_()
    assert repr(model).startswith("<foldproof.Model: 8 poses, ") and "key points" in repr(model)
    assert f"{model.chart_count:,}" in model._repr_html_()
    hierarchy = foldproof.Hierarchy(triangles, frames[0])
    assert repr(hierarchy) == f"<foldproof.Hierarchy: 305 vertices, 480 triangles, {hierarchy.leaf_count} leaves>"
    checker = foldproof.StepChecker(hierarchy)
    assert repr(checker.check(frames[0], frames[1])) == "<foldproof.StepResult: nothing collides>"
    assert "edge-edge pairs, the earliest at 0>" in repr(checker.check(frames[-2], frames[-1]))
    assert repr(checker.check_static(frames[0])) == "<foldproof.StaticResult: 0 crossing pairs>"
    assert "; only every 2nd frame was checked" in repr(foldproof.check(motion, frames="::2"))


def test_a_step_that_may_miss_says_so(motion, model):
    checker = foldproof.StepChecker(model)
    for mode, text in (("proven", "nothing collides"), ("paper", "STATISTICAL: nothing found")):
        found = checker.check(motion[0], motion[1], mode=mode)
        assert found.statistical == (mode == "paper") and text in repr(found)
    for mode, text in (("proven", " 0 crossing pairs>"), ("paper", "STATISTICAL: 0 crossing pairs found>")):
        pose = checker.check_static(motion[0], mode=mode)
        assert pose.statistical == (mode == "paper") and text in repr(pose)


def test_text_is_escaped(triangles, frames):
    assert "<b>" not in foldproof.Motion(triangles, frames, "<b>")._repr_html_()


def test_meshes_of_other_libraries(triangles, frames):
    expected = foldproof.Motion(triangles, frames[:3])
    assert foldproof.Motion.from_arrays(frames[:3], triangles) == expected
    trimeshes = [types.SimpleNamespace(vertices=x, faces=triangles) for x in frames[:3]]
    assert foldproof.Motion.from_meshes(trimeshes) == expected
    assert foldproof.Motion.from_meshes(trimeshes[0]) == expected[:1]
    quad = types.SimpleNamespace(type="quad", data=np.array([[0, 5, 6, 1]]))
    line = types.SimpleNamespace(type="line", data=np.array([[0, 1]]))
    read = foldproof.Motion.from_meshes(types.SimpleNamespace(points=frames[0], cells=[line, quad]), "read")
    assert read.triangles.tolist() == [[0, 5, 6], [0, 6, 1]] and read.name == "read"
    with pytest.raises(foldproof.Error, match=r"meshes\[1\]: has other faces than the first"):
        foldproof.Motion.from_meshes([trimeshes[0], types.SimpleNamespace(vertices=frames[0], faces=triangles[1:])])
    with pytest.raises(foldproof.Error, match="no cells of triangles"):
        foldproof.Motion.from_meshes(types.SimpleNamespace(points=frames[0], cells=[line]))
    polygon = types.SimpleNamespace(type="polygon", data=np.array([[0, 5, 6, 7, 1]]))
    with pytest.raises(foldproof.Error, match="cells of type polygon"):
        foldproof.Motion.from_meshes(types.SimpleNamespace(points=frames[0], cells=[quad, polygon]))
    with pytest.raises(foldproof.Error, match="are none"):
        foldproof.Motion.from_meshes([])
    with pytest.raises(TypeError, match="trimesh"):
        foldproof.Motion.from_meshes(3)


def test_errors_are_those_of_python(tmp_path, motion):
    with pytest.raises(FileNotFoundError) as missing:
        foldproof.load(tmp_path / "nowhere.model")
    assert isinstance(missing.value, foldproof.FileMissingError) and missing.value.filename == str(tmp_path / "nowhere.model")
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError) as refused:
        foldproof.write_motion(tmp_path / "file" / "out.npz", motion)
    assert isinstance(refused.value, (foldproof.FileError, ValueError))
    for error in (missing.value, refused.value, foldproof.Error("a\n", "is bad", "fix it")):
        copy = pickle.loads(pickle.dumps(error))
        assert type(copy) is type(error) and str(copy) == str(error) and copy.remedy == error.remedy
        assert "\n" not in str(error)


def test_plot(motion):
    pytest.importorskip("matplotlib")
    import matplotlib.pyplot as plt

    found = foldproof.check(motion, substeps=2, unit="m")
    figure = found.plot()
    pairs, contacts = figure.axes
    assert sum(bar.get_height() for bar in pairs.patches) == found.collisions
    assert len(contacts.patches) == len(found.contacts) and contacts.get_xlabel() == "frame"
    assert len(foldproof.check(motion, contacts=False).plot().axes) == 1
    plt.close("all")


def test_plot_without_matplotlib(motion, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match="plot needs Matplotlib .*install"):
        foldproof.check(motion, frames=slice(0, 2)).plot()
