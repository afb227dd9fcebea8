"""The bytes of the classic console's GIF at 256 and at 64 greys (paper, section 6.6: "about 10K" less)."""

from benchmarks.stage import median, tell


def main() -> None:
    """Compose panels over sand and things at both depths of grey."""
    import tempfile
    from pathlib import Path

    import numpy as np
    from PIL import Image

    from robots.kit.description import load
    from robots.kit.drivers.mercury.panel import compose
    from robots.kit.drivers.mercury.scara import scara
    from simulators.mercury.camera import expose
    from simulators.mercury.sand import SandBed

    bed, rng, description = SandBed(4), np.random.default_rng(1), load("mercury")
    for x, y in ((5, 420), (-150, 470), (110, 350)):
        for _ in range(7):
            for dx, dy in ((-8, 7), (8, 7), (8, -7), (-8, -7)):
                bed.blow(x + dx, y + dy, 0.15)
    sizes: dict[int, list[int]] = {256: [], 64: []}
    with tempfile.TemporaryDirectory() as folder:
        for x, y, z in (
            (0.0, 0.42, 0.0),
            (0.005, 0.42, 0.0),
            (-0.15, 0.47, 0.0),
            (0.11, 0.35, 0.075),
            (0.2, 0.5, 0.075),
        ):
            path = Path(folder) / "frame.png"
            Image.fromarray(expose(bed, [(x, y, z, 0.0)], 1 / 150, rng)).save(path)
            joints = list(scara(description).inverse(x, y, z, 0.0))
            for greys, found in sizes.items():
                found.append(len(compose(path, description, joints, greys)))
            print(f"at x={x} y={y} z={z} m: {sizes[256][-1]} bytes at 256 greys, {sizes[64][-1]} at 64")
    ratio = median([b / a for a, b in zip(sizes[256], sizes[64], strict=True)])
    beside = {"bytes_256": median(sizes[256]), "bytes_64": median(sizes[64])}
    tell("gif_bytes", ratio, "64 greys over 256 greys", "< 0.9", ratio < 0.9, beside)
