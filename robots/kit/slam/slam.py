"""RatSLAM (Ball et al. 2011, section 3.3) as one object: pictures and odometry in, a map out."""

import hashlib
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.kit.slam import checks
from robots.kit.slam.calibration import Calibration
from robots.kit.slam.cells import PoseCells
from robots.kit.slam.docks import DockPlaces
from robots.kit.slam.experiences import ExperienceMap, Pose, ring
from robots.kit.slam.pruning import pruned
from robots.kit.slam.routes import plan
from robots.kit.slam.settings import Settings
from robots.kit.slam.stream import ChangeLog, Changes
from robots.kit.slam.views import Grey, Views

MOST_HEIRS = 20_000  # pruned experiences whose successors are remembered
MOST_LOST = 1000  # experiences, more than are made between two saves
MOST_TIRED = 10.0  # otherwise a view before which the robot rested for an hour would never inject again


@dataclass(frozen=True)
class Step:
    """The result of a step. pose: x, y (m), facing (rad) on the map; experience: id, -1 before the first.

    picture: "seen", "none", "frozen", "black", "flat", or "full" if the map can hold no more; only "seen" teaches.
    is_new: the experience is new; met: an older experience was linked for the first time, as when a loop closes.
    """

    at_s: float
    map_number: int
    sequence: int
    pose: Pose
    experience: int
    picture: str
    is_new: bool
    met: bool


class RatSlam:
    """The robot's map and its place on it. Not for several threads at once.

    `keep`: ids of goals, which pruning never removes. `docks`: from where the dock was seen; pruning keeps one a place.
    """

    def __init__(self, settings: Settings | None = None, map_number: int = 1) -> None:
        self.settings = settings or Settings()
        self.map_number, self.sequence = map_number, 0
        self.keep: frozenset[int] = frozenset()
        self.odometry = Calibration()  # outlives the maps
        self._begin()

    def _begin(self) -> None:
        self.views, self.cells = Views(self.settings.views), PoseCells(self.settings.cells)
        self.map = ExperienceMap(self.settings.map)
        self.change_log, self.docks = ChangeLog(self.sequence), DockPlaces()
        self.view, self.last, self.pruned_at = -1, b"", 0
        self.heirs: dict[int, int] = {}  # pruned ids, and the ids of those that stayed where they were

    def clear(self) -> int:
        """Forget everything and return the number of the new map."""
        self.map_number += 1
        self.sequence += 1
        self._begin()
        return self.map_number

    def step(self, at_s: float, picture: Grey | None, v: float, w: float, dt: float) -> Step:
        """Take dt seconds of odometry (m/s, rad/s), and the newest grey picture if there is one.

        Raises ValueError, with nothing learnt, for what no robot can send.
        """
        at_s = checks.bounded("the time in s", at_s, -1e12, 1e12)
        v, w, dt = checks.odometry(v, w, dt)
        verdict, seen = self._look(picture)
        new = self._recognise(seen) if seen is not None else False
        turn = self.odometry.correct(v * dt, w * dt)
        self.cells.step(v * dt, turn)
        self.map.move(v * dt, turn, dt)
        made = met = False
        if seen is not None and new and self.views.count >= self.settings.map.most:
            verdict, self.view = "full", -1
        elif seen is not None:
            if new:
                self.view = self.views.add(seen, self.cells.best, self.settings.cells.tired)
            made, met, verdict = self._experience(verdict)
        return Step(at_s, self.map_number, self.sequence, self.map.pose(), self.experience, verdict, made, met)

    @property
    def experience(self) -> int:
        """The id of the current experience; -1 before the first."""
        return int(self.map.ids[self.map.current]) if self.map.current >= 0 else -1

    def _look(self, picture: Grey | None) -> tuple[str, Grey | None]:
        """Return the verdict on a picture, and the view to compare; None if the picture teaches nothing."""
        if picture is None:
            return "none", None
        view = self.views.view(picture)
        mark = hashlib.blake2b(np.ascontiguousarray(picture).tobytes(), digest_size=16).digest()
        frozen, self.last = mark == self.last, mark
        if view.mean() < self.settings.views.dark:
            return "black", None
        if view.std() < self.settings.views.flat:
            return "flat", None
        return ("frozen", None) if frozen else ("seen", view)

    def _recognise(self, view: Grey) -> bool:
        """Find the view among the templates and let it inject; tell whether it is new."""
        settings, views = self.settings.cells, self.views
        number, _ = views.match(view, self.view)
        if number >= 0:
            if number == self.view:
                views.decay[number] = min(views.decay[number] + settings.tired, MOST_TIRED)
            energy = settings.inject / 30.0 * (30.0 - math.exp(1.2 * views.decay[number]))
            if number < views.count - self.settings.views.young and energy > 0.0:
                x, y, heading = views.places[number]
                self.cells.inject((float(x), float(y), float(heading)), energy)
            self.view = number
        used = views.decay[: views.count]
        np.maximum(used - settings.restore, settings.tired, out=used)
        return number < 0

    def _experience(self, verdict: str) -> tuple[bool, bool, str]:
        """Choose, meet or make the experience of the current view; return made, met and the verdict."""
        graph, beyond = self.map, self.settings.map.new_beyond
        same = graph.current >= 0 and graph.views[graph.current] == self.view
        if same and self.cells.distances(graph.places[graph.current]) <= beyond:
            return False, False, verdict
        index, offset, link = self._met()
        if index >= 0:
            met = graph.meet(index, offset, link)
            if self.settings.calibrate:
                turned, gone, facing = graph.odometer[index].tolist()
                self.odometry.visited(turned, gone, offset[2] - facing)
            self._counted(offset[2])
            self._changed()
            return False, met, verdict
        if graph.count >= self.settings.map.most:
            return False, False, "full"
        graph.create(self.view, self.cells.best)
        self._counted(0.0)
        self._changed()
        return True, False, verdict

    def _met(self) -> tuple[int, Pose, bool]:
        """Return the experience (index) that the robot has come to, -1 if to none; its offset; whether to link it.

        It is the nearest by the pose cells that fits the map. One that does not fit counts, too, once several
        successive ones agree: either the map is wrong, and the link will correct it, or the robot was carried, and no
        link is made.
        """
        graph = self.map
        others = np.flatnonzero(graph.views[: graph.count] == self.view)
        others = others[others != graph.current]
        apart = self.cells.distances(graph.places[others])
        order = np.argsort(apart, kind="stable")
        near: list[int] = others[order][apart[order] < self.settings.map.new_beyond].tolist()
        found = [(index, self._offset(graph.places[index])) for index in near]
        for index, offset in found:
            if graph.fits(index, offset, math.sqrt(self.odometry.b)):
                return index, offset, True
        believed = graph.refuse(found, self.odometry.distance) if found else None
        return (*believed, graph.linkable(*believed)) if believed else (-1, (0.0, 0.0, 0.0), False)

    def _counted(self, facing: float) -> None:
        """Store the count of the odometry at the current experience, for the next visit."""
        self.map.odometer[self.map.current] = self.odometry.turned, self.odometry.distance, facing

    def _offset(self, place: NDArray[np.float64]) -> Pose:
        """Return where the pose cells say that the robot is, as seen from an experience at that place."""
        settings = self.settings.cells
        x, y = (ring(self.cells.best[i] - float(place[i]), settings.across) * settings.cell_m for i in (0, 1))
        per_layer = 2.0 * math.pi / settings.around
        facing = float(place[2]) * per_layer
        cos, sin = math.cos(facing), math.sin(facing)
        turned = ring(self.cells.best[2] - float(place[2]), settings.around) * per_layer
        return x * cos + y * sin, y * cos - x * sin, turned

    def _changed(self) -> None:
        """Relax after the current experience changed; prune if it is time; note the changes for readers."""
        self.map.relax()
        self.sequence += 1
        settings = self.settings
        if settings.pruning and self.map.next_id - self.pruned_at >= settings.map.prune_each:
            self.pruned_at = self.map.next_id
            self.prune()
        self.change_log.note(self.map, self.sequence)

    def prune(self) -> int:
        """Keep one experience a square and heading, and all of `keep`; return how many went."""
        before = self.map.count
        heirs, numbers = pruned(self.map, self.keep, self.views.keep, frozenset(self.docks.places))
        self.docks.inherit(heirs)
        self.view = numbers.get(self.view, -1)
        self.change_log = ChangeLog(self.sequence)
        self.heirs |= heirs
        for old in list(self.heirs)[:-MOST_HEIRS]:
            del self.heirs[old]
        return before - self.map.count

    def standing(self, experience: int) -> int:
        """Return the id of the experience that stays in place of a pruned one; any other id unchanged."""
        for _ in self.heirs:  # one that stayed may have been pruned later
            experience = self.heirs.get(experience, experience)
        return experience

    def skip_ids(self) -> None:
        """Leave out the ids that may have been in use after the map was saved; this map knows none of them."""
        self.map.next_id += MOST_LOST
        self.pruned_at += MOST_LOST

    def since(self, sequence: int) -> Changes:
        """Return what changed on the map after a sequence number; -1 asks for everything."""
        return self.change_log.since(self.map, self.map_number, self.sequence, sequence)


def compile_loops(settings: Settings | None = None) -> None:
    """Compile every loop before the robot moves, by a map of a few random pictures that is thrown away.

    At the first start on a machine this takes many seconds; later the stored code is loaded.
    """
    slam, dice = RatSlam(settings), np.random.default_rng(0)
    picture = slam.settings.views
    for n in range(4):
        blocks = dice.integers(0, 256, (picture.bottom, picture.width)).astype(np.uint8)
        slam.step(n, blocks, 0.2, 0.1, 0.5)
    plan(slam.map, 0)
