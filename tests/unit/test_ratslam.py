"""RatSLAM as a whole: it closes a loop, learns nothing from broken pictures, and goes on after a crash."""

import json
import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.slam.settings import MapSettings, Settings
from robots.kit.slam.slam import RatSlam
from robots.kit.slam.storage import BadMap, load, save
from tests.unit.ratslam_world import Drift, World, aligned, laps

DT = 0.05


@cache
def seen(x, seed=1):
    """Return the first picture of a small world, from a place in its first corridor."""
    return World(seed).picture(x, -0.775, 0.0)


class Drive:
    """Laps through the small world, with every fourth or fifth picture, and what became of them."""

    def __init__(self, slam, rounds, world=None, each=4):
        self.slam, self.each = slam, each
        world, drift = world or World(), Drift()
        self.truth, self.dead, self.steps, self.made = [], [], [], {}
        x = y = 0.0
        facing = math.pi / 2
        for n, (tx, ty, tf, v, w) in enumerate(laps(rounds)):
            picture = world.picture(tx, ty, tf) if n % each == 0 else None
            v, w = drift(v, w)
            facing += w * DT
            x, y = x + v * DT * math.cos(facing), y + v * DT * math.sin(facing)
            step = slam.step(n * DT, picture, v, w, DT)
            self.truth.append((tx, ty))
            self.dead.append((x, y))
            self.steps.append(step)
            if step.is_new:
                self.made[step.experience] = (tx, ty)

    def map_error(self):
        held = self.slam.map
        truth = np.array([self.made[i] for i in held.ids[: held.count].tolist()])
        return aligned(held.poses[: held.count, :2].copy(), truth)


@pytest.fixture(scope="module")
def drive():
    return Drive(RatSlam(), 2, each=5)


def test_a_loop_is_closed_and_the_error_shrinks(drive):
    half = len(drive.truth) // 2
    dead = aligned(np.array(drive.dead), np.array(drive.truth))
    assert any(step.met for step in drive.steps[half:])
    assert dead > 0.15
    assert drive.map_error() < dead / 4
    assert drive.map_error() < 0.05


def test_the_second_round_makes_fewer_experiences(drive):
    """Its pictures are taken up to 2 cm beside those of the first."""
    half = len(drive.steps) // 2
    first, second = (sum(step.is_new for step in part) for part in (drive.steps[:half], drive.steps[half:]))
    assert first > 80
    assert second < 0.8 * first


def test_the_robot_knows_where_it_is_in_the_second_round(drive):
    half = len(drive.steps) // 2 + 100
    found = np.array([step.pose[:2] for step in drive.steps[half:]])
    assert aligned(found, np.array(drive.truth[half:])) < 0.08


def test_one_sighting_of_a_place_far_away_moves_nobody_but_several_in_turn_do():
    """The pose cells, a ring of 0.2 m, may fit by chance; a robot that was carried sees one known place after another."""
    world, slam, route = World(), RatSlam(), list(laps(1))
    made = Drive(slam, 1, world, each=5).made
    half = len(route) // 2
    there = min(made, key=lambda i: math.dist(made[i], route[half][:2]))
    slam.cells.cells[:] = 0.0
    slam.cells.inject(tuple(slam.map.places[there]), 1.0)
    before, jumps = slam.map.pose(), []
    for n, (x, y, facing, v, w) in enumerate(route[half : half + 150]):
        step = slam.step(n * DT, world.picture(x, y, facing) if n % 5 == 0 else None, v, w, DT)
        if math.dist(before[:2], step.pose[:2]) > 0.3:
            jumps.append((step.experience, made[step.experience], slam.map.next_id - len(made)))
        before = step.pose
    (jump,) = jumps
    assert jump[2] >= 4, "until then it made experiences where the map had it"
    assert math.dist(jump[1], route[half][:2]) < 0.5


@pytest.mark.parametrize(
    ("picture", "verdict"),
    [
        (np.zeros((240, 416), np.uint8), "black"),
        (np.full((240, 416), 128, np.uint8), "flat"),
        (None, "none"),
    ],
)
def test_a_picture_that_shows_nothing_teaches_nothing(picture, verdict):
    slam = RatSlam()
    for n in range(20):
        step = slam.step(n * DT, picture, 0.1, 0.2, DT)
        assert (step.picture, step.experience, step.is_new) == (verdict, -1, False)
    assert slam.views.count == slam.map.count == 0
    assert step.pose != slam.map.pose_of(0)  # by odometry it has moved


def test_a_frozen_camera_teaches_nothing_until_it_moves_again():
    world, slam = World(), RatSlam()
    picture = world.picture(-0.5, -0.775, 0.0)
    assert slam.step(0.0, picture, 0.1, 0.0, DT).picture == "seen"
    before = slam.views.count, slam.map.count, slam.map.linked, slam.sequence
    for n in range(100):
        assert slam.step(n * DT, picture.copy(), 0.15, 0.0, DT).picture == "frozen"
    assert (slam.views.count, slam.map.count, slam.map.linked, slam.sequence) == before
    assert slam.step(6.0, world.picture(-0.2, -0.775, 0.0), 0.1, 0.0, DT).picture == "seen"
    assert slam.map.count == 2


finite = {"v": st.floats(-5, 5), "w": st.floats(-50, 50), "dt": st.floats(0, 1)}


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(*finite.values(), st.integers(0, 5)), min_size=1, max_size=15))
def test_any_odometry_in_bounds_keeps_everything_finite(steps):
    slam, dice = RatSlam(), np.random.default_rng(5)
    shown = [None, *(dice.integers(0, 256, (20, 60)).astype(np.uint8).repeat(12, 0).repeat(7, 1)[:, :416] for _ in range(5))]  # fmt: skip
    for n, (v, w, dt, which) in enumerate(steps):
        step = slam.step(n, shown[which], v, w, dt)
        assert all(map(math.isfinite, step.pose))
    assert slam.cells.cells.sum() == pytest.approx(1) and slam.cells.cells.min() >= 0
    assert np.isfinite(slam.map.poses).all() and np.isfinite(slam.map.measured).all()


@pytest.mark.parametrize(
    "bad", [math.nan, math.inf, -math.inf, 1e308, -1e308, pytest.param(10**400, id="huge"), "fast", None]
)
@pytest.mark.parametrize("which", ["v", "w", "dt", "at_s"])
def test_what_no_robot_sends_is_refused_with_a_sentence_and_changes_nothing(bad, which):
    slam = RatSlam()
    slam.step(0.0, seen(-0.5), 0.1, 0.0, DT)
    cells, pose, count = slam.cells.cells.copy(), slam.map.pose(), slam.map.count
    sent = {"at_s": 1.0, "v": 0.1, "w": 0.1, "dt": DT, which: bad}
    with pytest.raises(ValueError, match=r"must (be a number|lie between).*\.$"):
        slam.step(picture=seen(-0.5, 2), **sent)
    assert (slam.cells.cells == cells).all()
    assert (slam.map.pose(), slam.map.count, slam.views.count) == (pose, count, 1)


def test_clearing_begins_the_next_map_and_readers_get_all_of_it():
    slam = RatSlam()
    slam.step(0.0, seen(-0.5), 0.1, 0.0, DT)
    assert len(slam.since(-1).ids) == 1 and not slam.since(slam.sequence).whole
    read = slam.sequence
    assert slam.clear() == 2
    changes = slam.since(read)
    assert (changes.map_number, changes.whole, len(changes.ids), slam.experience) == (2, True, 0, -1)


def test_a_full_map_goes_on_without_learning():
    slam, dice = RatSlam(Settings(map=MapSettings(most=5))), np.random.default_rng(1)
    shown = [dice.integers(0, 256, (20, 60)).astype(np.uint8).repeat(12, 0).repeat(7, 1)[:, :416] for _ in range(12)]
    verdicts = [slam.step(n, picture, 0.1, 0.0, 0.5).picture for n, picture in enumerate(shown)]
    assert verdicts == ["seen"] * 5 + ["full"] * 7
    assert slam.map.count == 5 and slam.step(20, shown[2], 0.0, 0.0, DT).picture in ("seen", "full")


def test_with_pruning_the_map_stays_small_and_protected_places_stay():
    kept = Settings(pruning=True, map=MapSettings(prune_each=30, square_m=0.2))
    slam = RatSlam(kept)
    slam.keep = frozenset({1, 2})
    slam.docks.saw(3, 0.5, 0.1)
    drive = Drive(slam, 2)
    assert slam.map.next_id > 100 and slam.map.count < slam.map.next_id / 4
    assert {1, 2} <= set(slam.map.ids[: slam.map.count].tolist())
    assert list(slam.docks.places) == [slam.standing(3)], "from the same place the dock is seen"
    assert slam.views.count <= slam.map.next_id and set(slam.map.views[: slam.map.count]) == set(
        range(slam.views.count)
    )
    assert drive.map_error() < 0.15


def test_a_pruned_place_is_found_again_where_it_was(tmp_path):
    """Also after the one that stayed for it was pruned, too, and after the map was saved and read again."""
    world, slam = World(), RatSlam(Settings(pruning=True, map=MapSettings(prune_each=30, square_m=0.2)))
    drive = Drive(slam, 2, world)
    twice = [old for old, heir in slam.heirs.items() if heir in slam.heirs]
    assert len(slam.heirs) > 30 and twice
    on_map = set(slam.map.ids[: slam.map.count].tolist())
    assert {slam.standing(old) for old in slam.heirs} <= on_map
    apart = [math.dist(drive.made[old], drive.made[slam.standing(old)]) for old in slam.heirs]
    assert np.median(apart) < 0.2, "the same square, as far as the map was right when the one went"
    save(slam, tmp_path / "map.npz")
    again = load(tmp_path / "map.npz", slam.settings)
    assert again.heirs == slam.heirs
    assert again.standing(max(on_map)) == max(on_map) and again.standing(10**9) == 10**9


def test_a_loaded_map_gives_the_same_answers(tmp_path):
    world, slam = World(), RatSlam(Settings(pruning=True, map=MapSettings(prune_each=25)))
    Drive(slam, 1, world)
    slam.keep = frozenset({4})
    slam.docks.saw(7, 0.5, 0.1)
    save(slam, tmp_path / "map.npz")
    again = load(tmp_path / "map.npz", slam.settings)
    assert (again.map_number, again.sequence, again.keep) == (slam.map_number, slam.sequence, slam.keep)
    assert again.docks.places == slam.docks.places
    for n, (x, y, facing, v, w) in enumerate(list(laps(1, offset=0.03))[:400]):
        picture = world.picture(x, y, facing) if n % 3 == 0 else None
        assert slam.step(n, picture, v, w, DT) == again.step(n, picture, v, w, DT)
    assert (slam.cells.cells == again.cells.cells).all()
    one, two = slam.since(-1), again.since(-1)
    assert (one.ids == two.ids).all() and (one.poses == two.poses).all() and (one.links == two.links).all()


def test_which_links_were_measured_is_saved_and_an_older_map_is_read_as_one_that_was(tmp_path):
    world, slam = World(), RatSlam(Settings(pruning=True, map=MapSettings(prune_each=25)))
    Drive(slam, 1, world)
    save(slam, tmp_path / "map.npz")
    held, again = slam.map, load(tmp_path / "map.npz", slam.settings).map
    taken = held.taken[: held.linked]
    assert taken.any() and not taken.all()
    assert (again.taken[: again.linked] == taken).all() and again.pairs == held.pairs
    with np.load(tmp_path / "map.npz") as file:
        kept = {name: file[name] for name in file.files if name != "link_taken"}
    np.savez(tmp_path / "map.npz", **kept)
    assert load(tmp_path / "map.npz", slam.settings).map.taken[: held.linked].all()


def test_a_map_that_is_saved_again_replaces_the_old_one_at_once(tmp_path):
    slam = RatSlam()
    save(slam, tmp_path / "map.npz")
    slam.clear()
    save(slam, tmp_path / "map.npz")
    assert load(tmp_path / "map.npz").map_number == 2
    assert sorted(p.suffix for p in tmp_path.iterdir()) == [".npz", ".views"]


def test_templates_are_appended_and_a_crash_before_the_map_s_file_is_replaced_changes_nothing(tmp_path):
    """The templates' file is longer than the map says, then; the next save overwrites what is too much."""
    world, slam, path = World(), RatSlam(), tmp_path / "map.npz"

    def see(slam, x):
        slam.step(x, world.picture(x, -0.775, 0.0, noise=0.0), 0.3, 0.0, 0.5)

    see(slam, -0.6)
    save(slam, path)
    old = path.read_bytes()
    see(slam, -0.3)
    save(slam, path)
    (views,) = tmp_path.glob("*.views")
    assert views.stat().st_size == 2 * 1200
    path.write_bytes(old)
    again = load(path)
    assert again.views.count == 1
    for x in (0.0, 0.3):
        see(again, x)
    save(again, path)
    assert views.stat().st_size == 3 * 1200
    assert (load(path).views.templates[:3] == again.views.templates[:3]).all()
    views.unlink()
    save(again, path)  # somebody tidied up
    assert load(path).views.count == 3


def broken(path, how):
    """Write a saved map with one thing wrong."""
    slam = RatSlam()
    for n, x in enumerate((-0.5, -0.2, 0.1)):
        slam.step(n, seen(x), 0.3, 0.0, 1.0)
    save(slam, path)
    if how == "cut":
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    elif how == "flipped":
        content = bytearray(path.read_bytes())
        content[len(content) // 2] ^= 0xFF
        path.write_bytes(bytes(content))
    elif how == "text":
        path.write_text("no map")
    elif how == "empty":
        path.write_bytes(b"")
    elif how.endswith("templates"):
        (views,) = path.parent.glob("*.views")
        content = bytearray(views.read_bytes())
        content[7] ^= how == "flipped templates"
        views.write_bytes(content[:-1] if how == "cut templates" else content)
        _ = views.unlink() if how == "no templates" else None
    else:
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
        rest = json.loads(arrays["rest"].tobytes())
        if how == "link to nowhere":
            arrays["link_targets"][0] = 99
        elif how == "not finite":
            arrays["node_poses"][0, 0] = np.nan
        elif how == "shape":
            arrays["cells"] = arrays["cells"][:5]
        elif how == "other settings":
            rest["settings"]["map"]["loops"] = 7
        elif how == "no current":
            rest["current"] = 77
        elif how == "missing":
            del arrays["node_ids"]
        elif how == "negative":
            arrays["cells"][0, 0, 0] = -1.0
        elif how == "ids":
            rest["next_id"] = 1
        elif how == "path":
            rest["views"]["mark"] = "../../etc/passwd"
        elif how == "huge":
            rest["best"] = [1e400, 0, 0]
        arrays["rest"] = np.frombuffer(json.dumps(rest).encode(), np.uint8)
        with path.open("wb") as out:
            np.savez(out, **arrays)


@pytest.mark.parametrize("how", ["cut", "flipped", "text", "empty", "link to nowhere", "not finite", "shape", "other settings", "no current", "missing", "huge", "negative", "ids", "path", "cut templates", "flipped templates", "no templates"])  # fmt: skip
def test_a_damaged_map_is_refused_with_a_sentence(tmp_path, how):
    path = tmp_path / "map.npz"
    broken(path, how)
    with pytest.raises(BadMap, match=r"map\.npz is .*\.$"):
        load(path)


def test_no_map_is_no_damaged_map(tmp_path):
    with pytest.raises(FileNotFoundError):
        load(tmp_path / "map.npz")
