"""What implicit solvers ask: index lists and step sizes, held against NumPy."""
import threading

import numpy as np
import pytest

import foldproof
from conftest import rolled


def cloth_and_points(rng):
    """Two triangles, a rod of two edges, three points."""
    x = rng.random((12, 3))
    return x, np.array([[6, 7], [8, 7]]), np.array([[0, 1, 2], [3, 4, 5]])



def test_mesh_keeps_rows_and_adds_edges():
    x, edges, faces = cloth_and_points(np.random.default_rng(1))
    mesh = foldproof.CollisionMesh(x, edges, faces)
    assert mesh.vertex_count == 12 and mesh.edges.dtype == np.uint32
    np.testing.assert_array_equal(mesh.edges[:2], edges)
    assert len(mesh.edges) == 8 and {tuple(e) for e in mesh.edges[2:]} == {(0, 1), (0, 2), (1, 2), (3, 4), (3, 5), (4, 5)}
    np.testing.assert_array_equal(mesh.faces, faces)
    np.testing.assert_array_equal(mesh.codim_edges, [0, 1])
    np.testing.assert_array_equal(mesh.codim_points, [9, 10, 11])
    assert len(foldproof.CollisionMesh(x, edges, faces, points=False).codim_points) == 0
    with pytest.raises(ValueError, match="read-only"):
        mesh.edges[0, 0] = 3


def test_candidates_are_all_pairs_when_inflation_is_large():
    x, edges, faces = cloth_and_points(np.random.default_rng(2))
    mesh = foldproof.CollisionMesh(x, edges, faces)
    near = foldproof.ContactChecker(mesh).candidates(x, inflation=10)
    # 12 vertices and 2 faces less their corners; 8 edges less neighbors.
    assert near.vertex_face.shape == (12 * 2 - 6, 2)
    share = sum(len({*mesh.edges[a], *mesh.edges[b]}) == 4 for a in range(8) for b in range(a))
    assert near.edge_edge.shape == (share, 2) and (near.edge_edge[:, 0] < near.edge_edge[:, 1]).all()
    assert {tuple(p) for p in near.edge_vertex} == {(e, v) for e in (0, 1) for v in (9, 10, 11)}
    assert [tuple(p) for p in near.vertex_vertex] == [(9, 10), (9, 11), (10, 11)]
    assert len(near) == 18 + share + 6 + 3


def test_close_pairs_are_the_nearest_points():
    x, edges, faces = cloth_and_points(np.random.default_rng(5))
    mesh = foldproof.CollisionMesh(x, edges, faces)
    checker = foldproof.ContactChecker(mesh)
    pairs = checker.close_pairs(x, np.inf)
    assert pairs["count"].sum() == len(checker.candidates(x, inflation=10))
    difference = np.einsum("pk,pki->pi", pairs["weights"], x[pairs["vertices"]])
    np.testing.assert_allclose(np.linalg.norm(difference, axis=1), pairs["distance"], atol=1e-15)
    np.testing.assert_allclose(difference, pairs["distance"][:, None] * pairs["normal"], atol=1e-9)
    np.testing.assert_allclose(pairs["weights"].sum(axis=1), 0, atol=1e-15)
    of_points = pairs[(pairs["vertices"] >= 9).all(axis=1)]
    assert {foldproof.CLOSE_PAIR_KINDS[k] for k in of_points["kind"]} == {"vertex_vertex"} and len(of_points) == 3
    near = checker.close_pairs(x, np.median(pairs["distance"]))
    assert 0 < len(near) < len(pairs) and near["distance"].min() == checker.minimum_distance(x, np.inf)
    active = np.arange(12) == 9
    assert (checker.close_pairs(x, np.inf, active=active)["vertices"] == 9).any(axis=1).all()
    assert len(checker.close_pairs(x, np.inf, active)) == (pairs["vertices"] == 9).any(axis=1).sum() > 0
    for bad in ({"distance": -1}, {"distance": np.nan}, {"distance": 1, "active": np.arange(12)}, {"distance": 1, "active": [True]}):
        with pytest.raises(foldproof.Error):
            checker.close_pairs(x, **bad)


def test_excluded_groups():
    x, edges, faces = cloth_and_points(np.random.default_rng(3))
    groups = [0] * 6 + [1] * 6

    def near(**filtered):
        return foldproof.ContactChecker(foldproof.CollisionMesh(x, edges, faces, **filtered)).candidates(x, x, inflation=10)

    assert len(near(groups=groups).vertex_vertex) == 0  # no group with itself
    assert (near(groups=groups).vertex_face[:, 0] >= 6).all()
    assert len(near(groups=groups, excluded=[[0, 1]]).edge_vertex) == 6
    assert (near(groups=groups, excluded=[[0, 1]]).vertex_face[:, 0] < 6).all()
    assert len(near(groups=groups, excluded=[[0, 0], [0, 1], [1, 1]])) == 0


@pytest.mark.parametrize("certificates", [True, False])
def test_line_search_never_intersects(triangles, certificates):
    x0 = rolled(4.0)
    mesh = foldproof.CollisionMesh(x0, faces=triangles)
    checker = foldproof.ContactChecker(mesh, certificates=certificates)
    shares = []
    for turn in np.linspace(4.2, 9, 12):
        x1 = rolled(turn)
        share = checker.collision_free_step_size(x0, x1, 0.01)
        x = foldproof.step_towards(x0, x1, share)
        assert checker.limit == ("none" if share == 1 else "contact")
        assert checker.is_step_collision_free(x0, x, 0.01)
        assert checker.is_step_collision_free(x0, x1, 0.01) == (share == 1)
        assert not checker.has_intersections(x)
        assert checker.minimum_distance(x, 1) > 0.01
        assert checker.work["refits"] >= 1 and checker.work["node_tests"] > 0 and checker.milliseconds["total"] > 0
        shares.append(share)
    assert min(shares) < 1 == max(shares)


def test_points_meet_within_the_minimum_distance():
    x0, x1 = np.array([[0, 0, 0], [0, 0.1, 1.0]]), np.array([[0, 0, 0], [0, 0.1, -1.0]])
    checker = foldproof.ContactChecker(foldproof.CollisionMesh(x0), conservative_rescaling=1.0)
    assert checker.collision_free_step_size(x0, x1) == 1 and checker.contact is None
    assert checker.collision_free_step_size(x0, x1, 0.2) == pytest.approx((1 - np.sqrt(0.03)) / 2, abs=1e-6)
    time, pair = checker.contact
    assert checker.limit == "contact" and time == pytest.approx((1 - np.sqrt(0.03)) / 2, abs=1e-6)
    assert foldproof.CLOSE_PAIR_KINDS[pair["kind"]] == "vertex_vertex" and list(pair["vertices"][:2]) == [0, 1]
    assert pair["distance"] == pytest.approx(0.2, abs=1e-6)
    assert checker.collision_free_step_size(x0, x1, 1.1) == 0 and checker.limit == "start"
    assert checker.minimum_distance(x1, 2) == pytest.approx(np.hypot(1, 0.1), rel=1e-14)
    assert checker.minimum_distance(x1, 0.5) == np.inf


def test_one_contact_does_not_stop_the_others():
    x0 = np.array([[0.0, 0, 0], [2, 0, 0], [9, 0, 0]])
    x1 = x0 + [[1, 0, 0], [-1, 0, 0], [1, 0, 0]]
    checker = foldproof.ContactChecker(foldproof.CollisionMesh(x0))
    shares = checker.collision_free_step_sizes(x0, x1)
    assert shares == pytest.approx([0.8, 0.8, 1], abs=1e-6) and shares[2] == 1
    x = foldproof.step_towards(x0, x1, shares)
    assert (x[0] == x0[0] + shares[0] * (x1[0] - x0[0])).all() and checker.is_step_collision_free(x0, x)
    with pytest.raises(foldproof.Error, match="share"):
        foldproof.step_towards(x0, x1, shares[:1])
    with pytest.raises(ValueError):
        foldproof.step_towards(x0, x1, [[1], [1, 2]])  # no array


def test_steps_go_towards_what_was_proven():
    x0, x1 = np.array([[0.1, 0.2, 0.3]]), np.array([[1.1, -7.0, 0.3]])
    assert (foldproof.step_towards(x0, x1, 0.3) == x0 + 0.3 * (x1 - x0)).all()
    assert (foldproof.step_towards(x0, x1, np.float32(0.5)) == foldproof.step_towards(x0, x1, 0.5)).all()
    assert (foldproof.step_towards(x0, x1, 1) == x1).all()  # though x0 + (x1 - x0) may be another number
    with pytest.raises(foldproof.Error):
        foldproof.step_towards(x0, x1[:0], 0.5)


def test_refuses():
    x, edges, faces = cloth_and_points(np.random.default_rng(4))
    mesh = foldproof.CollisionMesh(x, edges, faces)
    checker = foldproof.ContactChecker(mesh)
    for bad in (lambda: foldproof.CollisionMesh(x, [[0, 12]]), lambda: foldproof.CollisionMesh(x, [[0, 1], [1, 0]]),
                lambda: foldproof.CollisionMesh(x, edges, faces, groups=[0, 1]),
                lambda: foldproof.CollisionMesh(x, edges, faces, excluded=[[0, 0]]),
                lambda: foldproof.CollisionMesh(x, [[0.5, 1]]), lambda: foldproof.CollisionMesh(x, faces=[[0, -1, 2]]),
                lambda: checker.candidates(x, inflation=-1), lambda: checker.is_step_collision_free(x, x[:3]),
                lambda: checker.minimum_distance(x * np.nan, 1)):
        with pytest.raises(foldproof.Error):
            bad()
    with pytest.raises(TypeError):
        foldproof.ContactChecker(None)
    with pytest.raises(foldproof.Error, match="^min_distance: is not a length"):
        checker.is_step_collision_free(x, x, -1)
    with pytest.raises(foldproof.Error, match="correct the face matrix"):
        foldproof.CollisionMesh(x, faces=[[0, 1, len(x)]])


def test_classes_say_what_they_are():
    x, edges, faces = cloth_and_points(np.random.default_rng(4))
    mesh = foldproof.CollisionMesh(x, edges, faces)
    checker = foldproof.ContactChecker(mesh)
    assert checker.mesh is mesh
    counts = f"{len(x)} vertices, {len(mesh.edges)} edges, {len(faces)} faces"
    assert repr(mesh) == f"<foldproof.CollisionMesh: {counts}>"
    assert repr(checker) == f"<foldproof.ContactChecker of {len(x)} vertices and {len(faces)} faces>"
    found = checker.candidates(x, inflation=10)
    assert f"{len(found.vertex_face):,} vertex-face, " in repr(found) and repr(found).endswith(" pairs>")


def test_many_threads_may_ask_one_checker(triangles):
    x = rolled(3.0)
    checker = foldproof.ContactChecker(foldproof.CollisionMesh(x, faces=triangles))
    answers = []
    threads = [threading.Thread(target=lambda: answers.append(len(checker.candidates(x, inflation=0.1).vertex_face)))
               for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(answers) == 4
