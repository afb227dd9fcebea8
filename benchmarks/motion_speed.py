"""What a faster arm costs in swing: time of a move, of the ringing, and of the stable picture, by speed."""

from benchmarks.stage import set_up, tell

SPEEDS = (0.10, 0.15, 0.20, 0.25, 0.30, 0.40, 0.50, 0.60)
MOVES = (
    (0.02, 0.43), (0.05, 0.42), (0.04, 0.45), (0.0, 0.42), (0.0, 0.47), (-0.03, 0.45),
    (-0.1, 0.36), (-0.07, 0.37), (0.0, 0.42), (0.2, 0.5), (0.17, 0.48), (0.0, 0.42),
)  # fmt: skip


def main() -> None:
    """Drive the simulator at each speed and look."""
    set_up()
    import tempfile
    import time
    from pathlib import Path

    from robots.kit.description import load
    from robots.kit.drivers.mercury.driver import Driver
    from robots.kit.vision.stability import settle
    from tests.rig import Simulator
    from workers.media.source import open_camera

    camera_about = load("mercury")["camera"]
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        sim = Simulator(Path(folder))
        try:
            for speed in SPEEDS:
                driver = Driver(str(sim.folder / "tty"), {"speed": speed})
                driver.connect()
                driver.recover(lambda: None)
                camera = open_camera("", sim.folder)
                totals, tries, stable = [], [], 0
                for x, y in MOVES:
                    begun = time.monotonic()
                    driver.execute("move", {"x": x, "y": y}, lambda: None, lambda _: None)
                    verdict = settle(
                        lambda c=camera: c.grab(camera_about["stability_exposure_s"]),
                        camera_about["stability_threshold"], camera_about["stability_tries"],
                    )  # fmt: skip
                    totals.append(time.monotonic() - begun)
                    tries.append(verdict.tries)
                    stable += verdict.stable
                driver.close()
                rows[speed] = (sum(totals) / len(totals), stable / len(MOVES), sum(tries) / len(tries))
                print(
                    f"{speed:.2f} m/s: {rows[speed][0]:.2f} s to the stable picture, {stable}/{len(MOVES)} stable, {rows[speed][2]:.1f} tries"
                )
        finally:
            sim.stop()
    default = float(load("mercury")["motion"]["speed"])
    sure = {s: r[0] for s, r in rows.items() if r[1] == 1.0}
    best = min(sure, key=lambda s: sure[s])
    ratio = rows[default][0] / sure[best]
    beside = {
        "fastest_always_stable_m_s": best,
        "default_m_s": default,
        "seconds_by_speed": {str(s): round(r[0], 2) for s, r in rows.items()},
    }
    tell(
        "motion_speed",
        ratio,
        "default over the best speed",
        "<= 1.15 and always stable",
        ratio <= 1.15 and rows[default][1] == 1.0,
        beside,
    )
