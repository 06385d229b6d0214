"""Trains a model, saves it, and rebuilds a pose that it has not seen from a few of its vertices."""
import numpy as np

import foldproof


def tail(angle: float, rings: int = 60, around: int = 12) -> np.ndarray:
    """A tube that bends by an angle, (rings x around) x 3; generated."""
    turn = angle * np.arange(rings) / rings
    spine = np.cumsum(np.stack([np.cos(turn), 0 * turn, np.sin(turn)], axis=-1), axis=0)
    phi = 2 * np.pi * np.arange(around) / around
    out = np.stack([-np.sin(turn), 0 * turn, np.cos(turn)], axis=-1)
    ring = out[:, None] * np.cos(phi)[:, None] + np.array([0, 1, 0]) * np.sin(phi)[:, None]
    points: np.ndarray = (spine[:, None] + ring).reshape(-1, 3)
    return points


v = np.arange(60 * 12).reshape(60, 12)
a, b, c, d = v[:-1], v[1:], np.roll(v, -1, axis=1)[1:], np.roll(v, -1, axis=1)[:-1]
triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])

poses = np.stack([tail(angle) for angle in np.linspace(-2, 2, 15)])
model = foldproof.train(foldproof.Motion(triangles, poses, "tail"))
model.save("tail.model")
model = foldproof.load("tail.model")

unseen = tail(1.23)
rebuilt = model.predict(unseen[model.key_points])
off = np.linalg.norm(rebuilt - unseen, axis=1).max()
shape = foldproof.ReducedShape(model)
print(f"{len(model.key_points)} of {len(unseen)} vertices tell the shape to within 1 of 60: {off < 1}")
print(f"shapes within {shape.radius():.2f} standard deviations of the mean cannot touch themselves")
# Prints: 14 of 720 vertices tell the shape to within 1 of 60: True
