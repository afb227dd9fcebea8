"""A mission of 12 steps as one message, beside its steps sent one after another, each when the last one's end is heard.

In virtual time: the rover's simulator with its firmware and hall, and its driver. Only the way between the person and
the driver is delayed. The rover knows where it is when it begins. `times` are those of the mission without any delay.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks.stage import set_up, tell

DELAYS_S = (0.12, 2.5)  # one way: the paper's Internet, and a satellite with a bad day
BOOT_S = 3.0
MOST = 1.1  # times the mission without a delay
STEPS = (
    "go South", "turn 90", "photograph", "read", "go Between cases", "photograph", "turn -45", "read", "go West", "photograph",
    "go Door", "say It is done.",
)  # fmt: skip


def main() -> None:
    """Time both ways at each delay."""
    set_up()
    physical, _ = timed(0.0, lambda send: send("\n".join(STEPS)))
    found = {}
    for delay in DELAYS_S:
        together, one = timed(delay, lambda send: send("\n".join(STEPS)))
        apart, many = timed(delay, lambda send: [send(step) for step in STEPS])
        found[delay] = together / physical, apart / physical, one, many
        print(
            f"delay {delay:g} s: one message {together:.1f} s, {many} messages {apart:.1f} s; {physical:.1f} s without"
        )
    worst = max(times for times, *_ in found.values())
    beside = {f"step_by_step_at_{delay:g}_s": round(apart, 3) for delay, (_, apart, *_) in found.items()}
    beside |= {"physical_s": round(physical, 1), "messages": found[DELAYS_S[0]][2]}
    tell("mission", round(worst, 3), "times the physical time, at the worse delay", f"<= {MOST}", worst <= MOST, beside)


def timed(delay: float, act: Callable[[Callable[[str], None]], object]) -> tuple[float, int]:
    """Return how long `act` takes (s) with a function that sends a mission and waits for its end, and its messages."""
    from tests.world.srv1 import RoverRig
    from tests.world.world import World

    world, messages = World(1), 0
    with tempfile.TemporaryDirectory() as folder:
        rig = RoverRig(world, Path(folder))
        took: list[float] = []

        def send(text: str) -> None:
            nonlocal messages
            messages += 1
            world.sleep(delay)
            session.execute("mission", {"text": text}, lambda: None, lambda stage: None)
            world.sleep(delay)

        def person() -> None:
            world.sleep(BOOT_S)
            session.connect()
            session.execute("look", {}, lambda: None, lambda stage: None)
            begun = world.monotonic()
            act(send)
            took.append(world.monotonic() - begun)

        session = rig.session("srv1", "", {"epoch": 1})
        world.spawn(person, "person", world.process("person", delayed=False))
        world.until(lambda: took, 3600, "the end of the mission")
        world.close()
        rig.close()
    return took[0], messages


if __name__ == "__main__":
    main()
