"""What a look at the objects means for the beliefs about them, and for a step of a task. Lengths in m, poses 4 x 4."""

from collections.abc import Iterator

import numpy as np

from robots.kit.arms.arrangement import Arrangement, NotPossible
from robots.kit.arms.beliefs import How, ObjectModel
from robots.kit.arms.chain import Matrix
from robots.kit.arms.objects import placed_of, pose_of
from robots.kit.arms.pose import apart, turned
from robots.kit.contract.objects import Placed
from robots.kit.drivers.arm_eyes import EXACTLY, Sight

CONFIRMED_MS = 60_000  # a place that is still the same is told as measured anew after this
HELD_M = 0.015  # an object this near to where the gripper holds it is in it
BESIDE_M, TURNED_RAD = 0.004, np.radians(4.0)  # off its place by more, it was not put there
ON_STUDS_M, FLAT_M = 0.002, 0.005  # so far too high it lies on another, and on the table, where a thin plate may be


def accept(model: ObjectModel, sight: Sight, tool: Matrix, now_ms: int) -> None:
    """Take over what a look of now has shown, the tool being at a pose: measured places, what is not where it was."""
    model.place_all({name: None for name in sorted(sight.missing)}, How.UNSEEN)
    model.place_all(dict(_changed(model, sight, tool, now_ms)), How.MEASURED)


def _changed(model: ObjectModel, sight: Sight, tool: Matrix, now_ms: int) -> Iterator[tuple[str, Placed]]:
    """Yield the places that are to be told, in the tool's frame for what is in the gripper; those of before if same."""
    seen = Arrangement(model.table, {n: placed_of(p) for n, p in sight.poses.items()})
    held = model.held
    if held is None:
        between = seen.between_fingers(tool)
        held = between if between is not None and _hovers(model, between, sight.poses[between]) else None
    for name, pose in sight.poses.items():
        belief = model.belief(name)
        before = belief.placed
        in_hand = name == held and (before is None or not before.held or apart(tool @ pose_of(before), pose) < HELD_M)
        now = placed_of(np.linalg.inv(tool) @ pose, held=True) if in_hand else placed_of(pose)
        if before is not None and before.held == in_hand and is_same(pose_of(before), pose_of(now), *sight.same):
            if belief.how != How.MEASURED or belief.at_ms < now_ms - CONFIRMED_MS:
                yield name, before
        elif _inside(model, pose):
            yield name, now


def _hovers(model: ObjectModel, name: str, pose: Matrix) -> bool:
    """Tell whether an object is where it would fall, unless something held it."""
    try:
        model.arrangement.without(name).settled(name, pose)
    except NotPossible:
        return True
    return False


def _inside(model: ObjectModel, pose: Matrix) -> bool:
    box = model.table.box
    return all(low <= at <= low + size for at, low, size in zip(pose[:3, 3], box.low, box.size, strict=True))


def is_same(one: Matrix, other: Matrix, m: float = EXACTLY[0], rad: float = EXACTLY[1]) -> bool:
    """Tell whether two poses differ by no more than a measurement does."""
    return apart(one, other) < m and turned(one, other) < rad


def check_in_hand(name: str, sight: Sight, held: Matrix) -> None:
    """Refuse where the pictures show that an object is not in the gripper, where it would be `held`.

    Raises NotPossible.
    """
    pose = sight.poses.get(name)
    if pose is not None and apart(pose, held) > HELD_M:
        raise NotPossible(f"the gripper is empty: the picture shows {name} at {place(pose)}")
    if name in sight.missing:
        raise NotPossible(f"the gripper is empty: the picture shows {name} neither in it nor where it was")


def check_put(name: str, sight: Sight, wanted: Matrix, on_other: bool) -> None:
    """Refuse where the pictures show that an object does not lie where it was put: on another one, or on the table.

    Raises NotPossible.
    """
    pose = sight.poses.get(name)
    if name in sight.missing:
        raise NotPossible(f"the picture does not show {name} where it was put")
    if pose is None:
        return
    more_m, more_rad = (rough - exact for rough, exact in zip(sight.same, EXACTLY, strict=True))
    up, beside = float(pose[2, 3] - wanted[2, 3]), float(np.hypot(*(pose[:2, 3] - wanted[:2, 3])))
    off = []
    if abs(up) > (ON_STUDS_M if on_other else FLAT_M) + more_m:
        off.append(f"{1000 * up:.0f} mm too high" if up > 0 else f"{-1000 * up:.0f} mm too low")
    if beside > BESIDE_M + more_m:
        off.append(f"{1000 * beside:.0f} mm beside its place")
    if turned(pose, wanted) > TURNED_RAD + more_rad:
        off.append(f"turned by {np.degrees(turned(pose, wanted)):.0f} degrees")
    if off:
        raise NotPossible(f"{name} does not lie as it was put: the picture shows it {', '.join(off)}")


def place(pose: Matrix) -> str:
    """Return where a pose is as tasks write it (mm)."""
    return f"{1000 * pose[0, 3]:.0f} {1000 * pose[1, 3]:.0f}"
