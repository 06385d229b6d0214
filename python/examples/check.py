"""Checks a motion that is made here: two crossing bars, of which one falls through the other."""
import numpy as np

import foldproof

box = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
triangles = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
still = np.stack([box * [10, 1, 1]] * 9)
falling = np.stack([box * [1, 10, 1] + [4.3, -4.6, height] for height in np.linspace(4, -4.3, 9)])

found = foldproof.check([foldproof.Motion(triangles, still, "bar"), foldproof.Motion(triangles, falling, "falling bar")])
first = found.steps[found.steps["edge_edge"] > 0][0]
print(f"{found.collisions} collisions; the first in frame {first['frame']}, {first['earliest_toi']:.3f} of the way")
for hit in found.edge_edge[:1]:
    print(f"edge {hit['a']} of object {hit['object_a']} meets edge {hit['b']} of object {hit['object_b']}")
# Prints: 64 collisions; the first in frame 2, 0.892 of the way
