"""Contacts of a motion that is made here: a ball dips into a floor, and leaves it again."""
import numpy as np

import foldproof

rings, around = 12, 24
theta, phi = np.meshgrid(np.linspace(0, np.pi, rings), np.arange(around) * 2 * np.pi / around, indexing="ij")
ball = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)[1:-1].reshape(-1, 3)
ball = 0.5 * np.concatenate([[[0, 0, 1]], ball, [[0, 0, -1]]]) + [0.013, 0.017, 0]
row = np.arange(around)
after = np.roll(row, -1)
faces = [np.stack([0 * row, 1 + row, 1 + after], -1)]
for k in range(rings - 3):
    a, b = 1 + k * around, 1 + (k + 1) * around
    faces += [np.stack([a + row, b + row, b + after], -1), np.stack([a + row, b + after, a + after], -1)]
last = 1 + (rings - 3) * around
faces.append(np.stack([last + row, 0 * row + len(ball) - 1, last + after], -1))
floor = np.array([[x, y, z] for x in (-3, 3) for y in (-3, 3) for z in (-1, 0)], float)
slab = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5], [2, 3, 7], [2, 7, 6], [0, 2, 6],
                 [0, 6, 4], [1, 5, 7], [1, 7, 3]])  # fmt: skip
heights = 0.35 + 0.6 * np.abs(np.linspace(-1, 1, 9))

motions = [
    foldproof.Motion(slab, np.stack([floor] * 9), "floor"),
    foldproof.Motion(np.concatenate(faces), np.stack([ball + [0, 0, height] for height in heights]), "ball"),
]
found = foldproof.check(motions, unit="m")
print(found.contacts)
deepest = found.contacts[0]
print(f"{deepest.between}: {deepest.depth:.3f} m deep in frame {deepest.worst:g}")
# Prints: floor - ball: 0.150 m deep in frame 4

# The same, frame by frame, as a simulation goes on:
finder = foldproof.ContactFinder([foldproof.Hierarchy(m.triangles, m[0]) for m in motions])
for x in zip(*motions):
    for contact in finder.add(list(x)):
        print("ended:", contact)
