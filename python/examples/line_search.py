"""A line search as implicit solvers have it: a sheet sinks towards a rod and a point, as far as is proven free."""
import numpy as np

import foldproof

n = 20
u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
sheet = np.stack([u, v, 0.3 + 0.05 * np.sin(7 * u) * np.cos(5 * v)], axis=-1).reshape(-1, 3)
rod_and_point = np.array([[0.2, 0.1, 0.05], [0.8, 0.6, 0.1], [0.3, 0.7, 0.0]])
x = np.concatenate([sheet, rod_and_point])
corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1, 1)
faces = np.concatenate([corner + [0, n, n + 1], corner + [0, n + 1, 1]])
mesh = foldproof.CollisionMesh(x, edges=[[n * n, n * n + 1]], faces=faces)  # rest positions, edges without a face, faces
checker = foldproof.ContactChecker(mesh)

shares = []
for _ in range(6):
    wanted = x.copy()
    wanted[: n * n, 2] -= 0.1
    share = checker.collision_free_step_size(x, wanted)
    x = foldproof.step_towards(x, wanted, share)  # what was proven, rounding included
    shares.append(share)
near = checker.candidates(x, inflation=0.05)  # for a barrier: ids of vertices and faces, rows of mesh.edges
print(f"{sum(s == 1 for s in shares)} whole steps, then shorter ones; intersections: {checker.has_intersections(x)};",
      f"near each other: {len(near.edge_edge) > 0 and 'edges' or 'none'}")
# Prints: 2 whole steps, then shorter ones; intersections: False; near each other: edges
