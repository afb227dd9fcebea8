"""The brain: RatSLAM with its goal, the dock's markers, and a folder in which it keeps the map."""

import copy
import logging
import math
import threading
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from robots.kit.clock import TIMER, Timer
from robots.kit.contract.errors import BadRequest
from robots.kit.description import load as described
from robots.kit.drivers.irat import markers as dock
from robots.kit.drivers.irat.brain import messages
from robots.kit.drivers.irat.brain.messages import Answer, FromBrain, Guided, Packet, Seen, ToBrain
from robots.kit.drivers.irat.brain.places import NO_PLACE, MapCleared, goal_place
from robots.kit.drivers.irat.brain.streams import CellStream, EarlierMap, MapStream
from robots.kit.drivers.irat.composites.decoding import MapShown
from robots.kit.files import replaced
from robots.kit.rovers.docking import Sighting
from robots.kit.slam.routes import Guide, plan
from robots.kit.slam.settings import Settings
from robots.kit.slam.slam import RatSlam
from robots.kit.slam.storage import BadMap, load, save
from robots.kit.slam.views import Grey, decoded
from robots.kit.vision.markers import Markers

log = logging.getLogger(__name__)
SAVE_S = 10.0  # between two saves, on the machine's clock unless it is given another: it spares the disk
WHERE_EACH = 10  # feeds, after which the place of the dock is computed again
LONGEST_STEP_S = 2.0  # the most that a map ages between two feeds
FIND_EACH = 4  # one of so many pictures is searched for the dock while the robot does not look for it
NO_WAY = "No way to this place is known."
IN_DOCK_M = (
    0.42  # to it a robot that does not dock comes no nearer than 0.52 m (wheels, steering); a goal reaches 0.1 m
)


class Mind:
    """Not for several threads. `folder` has `map.npz`, and `kept` with the map's number, its age and its care."""

    def __init__(self, folder: Path, clock: Timer = TIMER) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._clock, self._saving = folder, clock, threading.Lock()
        self._number, self._age, self._pruning = self._kept()
        self._earlier = EarlierMap(folder / "earlier")
        self.slam = self._restored()
        self._guide: Guide | None = None
        self._map_stream, self._cell_stream = MapStream(), CellStream()
        self._markers, self._ahead = dock_markers(), float(described("irat")["camera"]["ahead"])
        self._fed_at = math.inf  # of the newest feed
        self._pictures, self._saved = 0, self._clock.monotonic()
        self._feeds, self._dock_at, self._dock_map = 0, self._where(), self.slam.map_number

    def _kept(self) -> tuple[int, float, bool]:
        try:
            number, age, pruning = (self._folder / "kept").read_text().split()
            return int(number), float(age), pruning == "pruning"
        except (OSError, ValueError):
            return 0, 0.0, False

    def _restored(self) -> RatSlam:
        path, lost = self._folder / "map.npz", False
        for pruning in (self._pruning, not self._pruning):
            try:
                slam = load(path, Settings(pruning=pruning))
            except FileNotFoundError:
                break
            except BadMap as error:
                log.warning("%s", error)
                lost = True
                continue
            slam.settings = Settings(pruning=self._pruning)
            if slam.map_number == self._number:
                slam.skip_ids()
                return slam
            lost = False  # the file has the map before this one, which was cleared
        if lost:
            self._earlier.was_lost(self._number, self._age)
        self._number, self._age = self._number + 1, 0.0
        self._keep()
        return RatSlam(Settings(pruning=self._pruning), self._number)

    def _keep(self) -> None:
        with replaced(self._folder / "kept") as out:
            out.write(f"{self._number} {self._age:.1f} {'pruning' if self._pruning else 'clearing'}\n".encode())

    def take(self, message: ToBrain) -> Iterator[FromBrain]:
        """Yield the answers to a message."""
        match message:
            case messages.Feed():
                yield from self._fed(message)
            case messages.Aim():
                yield self._aimed(message)
            case messages.AimAtDock(number, tried):
                found = self.slam.docks.best(tried)
                yield Answer(number, NO_PLACE) if found is None else self._to(number, found)
            case messages.Forget(place):
                self._guide, self.slam.keep = None, frozenset()
                self.slam.docks.forget(place)
            case messages.Clear(number, why):
                self._earlier.was(self.slam, self._where(), IN_DOCK_M, self._age, why)
                self._guide, self._age = None, 0.0
                self._number = self.slam.clear()
                self._keep()
                yield Answer(number)
            case messages.Care(number, pruning):
                self._pruning, self.slam.settings = pruning, replace(self.slam.settings, pruning=pruning)
                self._keep()
                yield Answer(number)
            case messages.Save(number):
                self.save()
                yield Answer(number)
            case messages.Key(stream):
                told = (
                    self._earlier if stream == "earlier" else self._map_stream if stream == "map" else self._cell_stream
                )
                told.key = True

    def _aimed(self, wanted: messages.Aim) -> Answer:
        stands = self.slam.standing(wanted.experience)
        try:
            return self._to(wanted.number, goal_place(self.map_shown(), wanted.map_number, wanted.x, wanted.y, stands))
        except BadRequest as error:
            return Answer(wanted.number, str(error), cleared=isinstance(error, MapCleared))

    def map_shown(self) -> MapShown:
        """Return the places of the map as goals are judged by them: without links and routes."""
        held, where = self.slam.map, self._where()
        ids, places = held.ids[: held.count].astype(np.int64), held.poses[: held.count, :2]
        return MapShown(self.slam.map_number, ids, places, dock=(*where, IN_DOCK_M) if where else None)

    def _where(self) -> tuple[float, float] | None:
        return self.slam.docks.where(self.slam.map, self._ahead)

    def _to(self, number: int, goal: int) -> Answer:
        route = plan(self.slam.map, goal)
        if route is None:
            return Answer(number, NO_WAY, experience=goal)
        self._guide, self.slam.keep = Guide(goal), frozenset({goal})
        return Answer(number, experience=goal, limit_s=route.limit_s)

    def _fed(self, feed: messages.Feed) -> Iterator[FromBrain]:
        picture = None
        if feed.jpeg is not None:
            try:
                picture = decoded(feed.jpeg)
            except ValueError as error:
                log.warning("a picture was not used: %s", error)
        slam = self.slam
        try:
            step = slam.step(feed.at, picture, feed.v, feed.w, feed.dt)
        except ValueError as error:
            log.warning("a step was not used: %s", error)
            step = slam.step(0.0, None, 0.0, 0.0, 0.0)
        if not feed.docked:
            self._age += min(max(0.0, feed.at - self._fed_at), LONGEST_STEP_S)
        self._fed_at = feed.at
        outer, small = self._dock(picture, feed.find)
        self._feeds += 1
        if self._feeds % WHERE_EACH == 0 or step.map_number != self._dock_map:  # it moves slowly, as the map is relaxed
            self._dock_at, self._dock_map = self._where(), step.map_number
        if outer is not None:
            slam.docks.saw(step.experience, outer.z, outer.theta)
        guided, route = self._guided()
        yield Seen(
            feed.at, step.map_number, step.pose, step.experience, slam.map.count, len(slam.docks.places),
            step.picture, self._pruning, self._age, guided, outer, small,
        )  # fmt: skip
        yield from self._packets(route)
        if self._clock.monotonic() - self._saved > SAVE_S:
            self._save_beside()

    def _dock(self, picture: Grey | None, find: bool) -> tuple[Sighting | None, Sighting | None]:
        """Return the outer and the small marker, where they are looked for and seen."""
        if picture is None:
            return None, None
        self._pictures += 1
        if not find and self._pictures % FIND_EACH:
            return None, None
        seen = self._markers.find(picture)
        outer = next((m.sighting for m in seen if m.number in dock.OUTER_IDS), None)
        return outer, next((m.sighting for m in seen if m.number == dock.SMALL_ID), None)

    def _guided(self) -> tuple[Guided | None, tuple[int, ...]]:
        look = self._guide.look(self.slam.map) if self._guide and self.slam.map.count else None
        if look is None or self._guide is None:
            return None, ()
        return Guided(self._guide.goal, look.reached, look.bearing, look.distance), look.route.ids

    def _packets(self, route: tuple[int, ...]) -> Iterator[Packet]:
        if (earlier := self._earlier.next()) is not None:
            yield Packet("earlier", earlier, True)
        for name, packet in (
            ("map", self._map_stream.next(self.slam, route, self._dock_at, IN_DOCK_M)),
            ("cells", self._cell_stream.next(self.slam.cells.cells)),
        ):
            if packet is not None:
                yield Packet(name, *packet)

    def _save_beside(self) -> None:
        """Write a copy of the map in another thread, because a slow disk must not stop the robot."""
        self._saved = self._clock.monotonic()
        self._keep()
        if not self._saving.locked():
            self._clock.spawn(partial(self._write, copy.deepcopy(self.slam)), "brain-save")

    def save(self) -> None:
        """Write the map now."""
        self._keep()
        self._write(self.slam)

    def _write(self, slam: RatSlam) -> None:
        with self._saving:
            try:
                save(slam, self._folder / "map.npz")
            except OSError as error:
                log.error("the map could not be saved: %s", error)
                return
            ours = self.slam.views  # a copy was saved: the next save writes only what is new since
            if ours.mark == slam.views.mark:
                ours.stored_count = slam.views.stored_count


def dock_markers() -> Markers:
    """Return the detector of the dock's markers."""
    sides = {**dict.fromkeys(dock.OUTER_IDS, dock.OUTER_M), dock.SMALL_ID: dock.SMALL_M}
    field = float(described("irat")["camera"]["field"])
    return Markers(dict(enumerate(dock.BITS)), sides, field, frozenset({dock.SMALL_ID}))
