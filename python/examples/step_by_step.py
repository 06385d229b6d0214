"""Steps of a simulation, checked one by one: a step that would collide is shortened until it does not."""
import numpy as np

import foldproof

floor = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], float)
patch = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1.2], [0, 1, 1.1]], float)
quad = np.array([[0, 1, 2], [0, 2, 3]])
checker = foldproof.StepChecker([foldproof.Hierarchy(quad, floor), foldproof.Hierarchy(quad, patch)])

velocity, steps, shortened = np.zeros(3), 0, 0
for _ in range(40):
    velocity += [0, 0, -9.81 / 60]
    wanted = patch + velocity / 60
    answer = checker.check([floor, patch], [floor, wanted], thickness=1e-3, earliest_only=True)
    if not answer.clean:
        wanted = patch + 0.9 * answer.earliest_toi * (wanted - patch)  # nothing touches before that time
        velocity[:] = 0
        shortened += 1
    patch = wanted
print(f"after 40 steps, {shortened > 0 and 'some' or 'none'} of them shortened, it lies on the floor: {patch[:, 2].min() > 0}")
# Prints: after 40 steps, some of them shortened, it lies on the floor: True
