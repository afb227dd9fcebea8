"""A small world for RatSLAM: a ring of corridors with textured walls, a camera of 110 degrees, odometry that drifts."""

import math

import numpy as np

WIDTH, HEIGHT, HALF_VIEW = 416, 240, math.radians(55)
COLUMNS = 104  # rays a picture; each makes four columns
FOCAL = WIDTH / 2 / math.tan(HALF_VIEW)
CAMERA_M, WALL_M = 0.05, 0.14
OUTER, INNER = (1.05, 0.95), (0.7, 0.6)  # half the sides of the two rectangles between which the corridor runs


RING = ((-INNER[0], INNER[0], -INNER[1], INNER[1]),)


class World:
    """A rectangle of walls round the origin and blocks in it; every wall has a texture of its own.

    blocks: least and greatest x, least and greatest y (m) of each.
    """

    def __init__(self, seed=1, blocks=RING):
        self.dice = np.random.default_rng(seed)
        ends = []
        for a, b, c, d in ((-OUTER[0], OUTER[0], -OUTER[1], OUTER[1]), *blocks):
            corners = [(a, c), (b, c), (b, d), (a, d)]
            ends += [(corners[i], corners[(i + 1) % 4]) for i in range(4)]
        self.begin = np.array([a for a, _ in ends], float)
        self.along = np.array([b for _, b in ends], float) - self.begin
        self.length = np.hypot(*self.along.T)
        self.grain = self.dice.standard_normal((2 * HEIGHT, 2 * WIDTH), np.float32)
        # grey levels every 4 cm of a wall and 2 cm of its height
        self.paint = self.dice.uniform(30, 225, (len(ends), 64, 8))

    def picture(self, x, y, facing, noise=2.0):
        """Return what the camera sees, (240, 416) of 8 bits."""
        offsets = (np.arange(COLUMNS) + 0.5) / COLUMNS * WIDTH - WIDTH / 2
        angles = facing - np.arctan(offsets / FOCAL)
        rays = np.column_stack([np.cos(angles), np.sin(angles)])
        to = self.begin[None] - np.array([x, y])
        across = rays[:, None, 0] * self.along[None, :, 1] - rays[:, None, 1] * self.along[None, :, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            far = (to[..., 0] * self.along[None, :, 1] - to[..., 1] * self.along[None, :, 0]) / across
            at = (to[..., 0] * rays[:, None, 1] - to[..., 1] * rays[:, None, 0]) / across
        far = np.where((far > 1e-6) & (at >= 0) & (at <= 1), far, np.inf)
        wall = np.argmin(far, axis=1)
        pick = np.arange(COLUMNS)
        depth = far[pick, wall] * np.cos(angles - facing)
        metres = at[pick, wall] * self.length[wall]
        up = CAMERA_M + (HEIGHT / 2 - np.arange(HEIGHT)[:, None] - 0.5) / FOCAL * depth[None]
        row = np.clip((up / 0.02).astype(int), 0, 7)
        place = metres / 0.04
        left = np.clip(place.astype(int), 0, 62)
        part = place - left
        seen = self.paint[wall[None], left[None], row] * (1 - part) + self.paint[wall[None], left[None] + 1, row] * part
        seen = np.where(up < 0, 20.0, np.where(up > WALL_M, 90.0, seen))
        full = np.repeat(seen, WIDTH // COLUMNS, axis=1).astype(np.float32)
        if noise:
            top, left = self.dice.integers(0, HEIGHT), self.dice.integers(0, WIDTH)
            full += noise * self.grain[top : top + HEIGHT, left : left + WIDTH]
        return np.clip(full, 0, 255).astype(np.uint8)


def laps(count, speed=0.15, dt=0.05, offset=0.0):
    """Yield (x, y, facing, v, w) of a drive along the middle of the corridor, `count` times round."""
    half = ((OUTER[0] + INNER[0]) / 2 + offset, (OUTER[1] + INNER[1]) / 2 + offset)
    radius = 0.12
    x, y, facing = -half[0] + radius, -half[1], 0.0
    for _ in range(count):
        for side in range(4):
            straight = 2 * half[side % 2] - 2 * radius
            corner = math.pi / 2 * radius
            for length, turning in ((straight, 0.0), (corner, speed / radius)):
                steps = max(1, round(length / speed / dt))
                v, w = length / steps / dt, (math.pi / 2 / steps / dt if turning else 0.0)
                for _ in range(steps):
                    middle = facing + w * dt / 2
                    x, y, facing = x + v * dt * math.cos(middle), y + v * dt * math.sin(middle), facing + w * dt
                    yield x, y, facing, v, w


class Drift:
    """Odometry that is wrong by a share, by a bias in turning and by noise."""

    def __init__(self, seed=2, share=1.03, bias=0.01, noise=0.02):
        self.dice, self.share, self.bias, self.noise = np.random.default_rng(seed), share, bias, noise

    def __call__(self, v, w):
        spread = self.dice.normal(1, self.noise, 2)
        return v * self.share * spread[0], w * spread[1] + (self.bias if v or w else 0.0)


def aligned(found, truth):
    """Return the root mean square distance (m) of two paths, (n, 2), after the best turn and shift of the first."""
    a, b = found - found.mean(axis=0), truth - truth.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    flip = np.diag([1.0, np.sign(np.linalg.det(u @ vt))])
    return float(np.sqrt(np.square(a @ u @ flip @ vt - b).sum(axis=1).mean()))
