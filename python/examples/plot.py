"""Plots how many pairs collide in each step of a motion, and where, into collisions.png."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import foldproof

# A strip that rolls up; generated.
length, width = 80, 6
v = np.arange((length + 1) * (width + 1)).reshape(length + 1, width + 1)
a, b, c, d = v[:-1, :-1], v[1:, :-1], v[1:, 1:], v[:-1, 1:]
triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])


def rolled(turn: float) -> np.ndarray:
    angle = turn * np.arange(length + 1) / length
    x, z = np.cumsum(np.cos(angle)), np.cumsum(np.sin(angle))
    across = np.arange(width + 1.0)
    points: np.ndarray = np.stack(np.broadcast_arrays(x[:, None] + 0.1 * across, across, z[:, None]), -1).reshape(-1, 3)
    return points


frames = np.stack([rolled(turn) for turn in np.linspace(1, 9, 25)])
found = foldproof.check(foldproof.Motion(triangles, frames))

last = foldproof.StepChecker(foldproof.Hierarchy(triangles, frames[0])).check(frames[-2], frames[-1])
faces = last.colliding_faces(foldproof.Hierarchy(triangles, frames[0]))

figure = plt.figure(figsize=(10, 4))
counts = figure.add_subplot(1, 2, 1, xlabel="frame", ylabel="colliding pairs")
counts.bar(found.steps["frame"], found.steps["vertex_face"] + found.steps["edge_edge"])
mesh = figure.add_subplot(1, 2, 2, projection="3d", box_aspect=np.ptp(frames[-1], axis=0))
for marked, color in ((faces, "crimson"), (~faces, "lightgrey")):
    mesh.plot_trisurf(*frames[-1].T, triangles=triangles[marked], color=color)
figure.savefig("collisions.png", dpi=100)
print(f"collisions.png: {np.count_nonzero(found.steps['edge_edge'])} of {len(found.steps)} steps collide")
# Prints: collisions.png: 9 of 24 steps collide
