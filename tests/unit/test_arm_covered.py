"""Every body that is checked against boxes covers the arm's shapes, as the URDF describes them, wherever the fingers are."""

from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robots.kit.arms.described import chain, planner, posture, zones
from robots.kit.arms.planner import Refused
from robots.kit.description import load, text_of

ARMS = ("pa10", "puma")
URDF = {driver: ElementTree.fromstring(text_of(driver, "model.urdf")) for driver in ARMS}
FINE_M = 0.004  # between two samples
BOLTED = ("base", "shoulder")  # they stand where they stand: no motion takes them into a box
MOVED = ("upper_arm", "forearm", "lower_forearm", "wrist", "tool", "left_pad", "right_pad")
both = pytest.mark.parametrize("driver", ARMS)


def transform(element):
    made = np.eye(4)
    if element is not None:
        made[:3, 3] = [float(v) for v in element.get("xyz", "0 0 0").split()]
        turned = [float(v) for v in element.get("rpy", "0 0 0").split()]
        made[:3, :3] = Rotation.from_euler("xyz", turned).as_matrix()
    return made


def steps(low, high):
    return np.linspace(low, high, max(2, round((high - low) / FINE_M) + 1))


def box(size):
    """Return samples (n, 3) of its surface."""
    axes = [steps(-v / 2, v / 2) for v in size]
    found = []
    for k in range(3):
        across = np.array(np.meshgrid(*(axes[i] for i in range(3) if i != k))).reshape(2, -1)
        for end in (axes[k][0], axes[k][-1]):
            found.append(np.insert(across, k, end, axis=0).T)
    return np.concatenate(found)


def cylinder(radius, length):
    """Return samples (n, 3) of its wall, and of the rims, which reach farther than the rest of its ends."""
    turn, z = np.meshgrid(np.arange(0, 2 * np.pi, FINE_M / radius), steps(-length / 2, length / 2))
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=-1).reshape(-1, 3)


def samples(driver, link, opening):
    """Return samples of all shapes of a link in the frame that moves with its joint, and that joint's name."""
    urdf = URDF[driver]
    (body,) = (one for one in urdf.findall("link") if one.get("name") == link)
    found = []
    for shape in (*body.findall("visual"), *body.findall("collision")):
        geometry = shape.find("geometry")
        if (made := geometry.find("box")) is not None:
            points = box([float(v) for v in made.get("size").split()])
        else:
            made = geometry.find("cylinder")
            points = cylinder(float(made.get("radius")), float(made.get("length")))
        at = transform(shape.find("origin"))
        found.append(points @ at[:3, :3].T + at[:3, 3])
    points = np.concatenate(found)
    (joint,) = (one for one in urdf.findall("joint") if one.find("child").get("link") == link)
    while joint.get("type") != "revolute":  # a finger slides in the frame of the last axis
        at = transform(joint.find("origin"))
        if joint.get("type") == "prismatic":
            at[:3, 3] += opening * np.array([float(v) for v in joint.find("axis").get("xyz").split()])
        points = points @ at[:3, :3].T + at[:3, 3]
        parent = joint.find("parent").get("link")
        (joint,) = (one for one in urdf.findall("joint") if one.find("child").get("link") == parent)
    return points, joint.get("name")


def postures(driver):
    """Yield joints (rad): at the ends of their ranges, at rest, and anywhere."""
    arm, dice = chain(driver), np.random.default_rng(1)
    yield from (arm.low, arm.high, posture(load(driver), "home"), posture(load(driver), "ready"))
    for _ in range(12):
        yield dice.uniform(arm.low, arm.high)


def beyond(driver, points, joint, q):
    """Return how far each sample is outside all capsules (m), negative inside, with the arm at `q`."""
    arm = chain(driver)
    frames = arm.frames(q)
    at = frames[arm.names.index(joint)]
    there, found = points @ at[:3, :3].T + at[:3, 3], []
    for limb in zones(driver)._limbs:
        begin, end = ((frames[limb.joint] @ [*point, 1.0])[:3] for point in (limb.begin, limb.end))
        share = np.clip((there - begin) @ (end - begin) / np.square(end - begin).sum(), 0, 1)
        found.append(np.linalg.norm(there - begin - share[:, None] * (end - begin), axis=1) - limb.radius)
    return np.min(found, axis=0)


@both
def test_all_that_moves_is_looked_at(driver):
    shapes = [link.get("name") for link in URDF[driver].findall("link") if link.find("visual") is not None]
    assert tuple(name for name in shapes if name not in BOLTED) == MOVED


@both
@pytest.mark.parametrize("link", MOVED)
def test_no_shape_sticks_out_of_the_capsules(driver, link):
    for opening in np.linspace(0.0, load(driver)["gripper"]["open"], 3 if "pad" in link else 1):
        points, joint = samples(driver, link, opening)
        out = max(beyond(driver, points, joint, q).max() for q in postures(driver))
        assert out <= 0.0, f"{link} sticks out by {1000 * out:.1f} mm"


@both
def test_no_accepted_posture_puts_a_shape_into_a_box(driver):
    """Postures at the edge of what is accepted: where a limb has just entered, and a little back from there."""
    arm, made, dice = chain(driver), planner(driver), np.random.default_rng(4)
    shapes = [samples(driver, link, load(driver)["gripper"]["open"]) for link in MOVED]
    accepted = 0
    while accepted < 60:
        free, entered = dice.uniform(arm.low, arm.high), dice.uniform(arm.low, arm.high)
        if not stands(made, free) or stands(made, entered):
            continue
        for _ in range(30):
            middle = (free + entered) / 2
            free, entered = (middle, entered) if stands(made, middle) else (free, middle)
        accepted += 1
        frames = arm.frames(free)
        for points, joint in shapes:
            at = frames[arm.names.index(joint)]
            there = points @ at[:3, :3].T + at[:3, 3]
            for forbidden in made.zones.boxes:
                if arm.names.index(joint) == 1 and forbidden.name == "the base":
                    continue  # bolted above it
                inside = ((there > forbidden.low) & (there < forbidden.high)).all(axis=1)
                assert not inside.any(), (free, joint, forbidden.name)


def stands(made, q):
    try:
        made.stand(q)
    except Refused:
        return False
    return True
