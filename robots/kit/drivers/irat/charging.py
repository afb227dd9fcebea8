"""Charging (section 3.5): to a place from where the dock was seen, into the dock by sight of its markers, and rest.

The robot counts as charging only while the charger gives a current.
"""

from math import pi

from robots.kit.contract.errors import GaveUp
from robots.kit.contract.session import JSON, OnStage, Permit, Progress
from robots.kit.drivers.irat.brain.messages import NONE, Aim, AimAtDock, Forget, Seen
from robots.kit.drivers.irat.protocol import Velocity
from robots.kit.drivers.irat.spec import FULL, Mode
from robots.kit.drivers.irat.wheels import REST, STEP_S, Wheels
from robots.kit.rovers.docking import Docking, Sighting, dock

TRIES = 12  # of docking
SURE = 2  # successive pictures in which the outer marker has to be seen
NEAR_M, ASIDE = 1.7, 0.95  # the marker is used from here, if it is wholly in the picture
OLD_S = 0.3  # of a sighting
TURN_RAD_S = 1.0  # looking round at a place
PLACE_S = 120.0  # on the way to one place
UNLED_S = 3.0  # without guidance to a place for so long, it tries another
ROAM_S = 60.0  # without a place to try it roams for so long, then all places are tried again
TELL_S = 10.0  # between two reports of the charge


class Charging:
    """Carries out the command `charge`, the robot's need."""

    def __init__(self, wheels: Wheels) -> None:
        self._wheels, self._brain, self._senses = wheels, wheels.brain, wheels.senses
        self._clock = wheels.clock
        self._tried: list[int] = []
        self._seen_at = 0.0  # of the brain's answer that was used last
        self._sightings = 0

    def charge(self, permit: Permit, on_stage: OnStage) -> JSON:
        """Dock and charge. Raises GaveUp when no try succeeds, HardwareFault when the battery is almost flat."""
        began, share = self._clock.monotonic(), self._senses.share
        permit()
        on_stage("sent")
        on_stage("acknowledged")
        tries = 0
        while not self._full:
            if not self._senses.charging:
                tries += self._dock(permit, on_stage)
                if tries >= TRIES:
                    raise GaveUp(f"The robot did not get into its dock in {tries} tries; its contacts may be bent.")
            self._rest(permit, on_stage)
        return {"tries": tries, "from": round(100 * share, 1), "seconds": round(self._clock.monotonic() - began)}

    @property
    def _full(self) -> bool:
        return self._senses.charging and (self._senses.full or 100 * self._senses.share >= FULL)

    def _rest(self, permit: Permit, on_stage: OnStage) -> None:
        """Wait in the dock while current flows; nothing moves."""
        told, self._senses.mode = 0.0, Mode.CHARGING
        try:
            while self._senses.charging and not self._full:
                permit()
                self._clock.sleep(STEP_S)
                if self._clock.monotonic() - told > TELL_S:
                    told = self._clock.monotonic()
                    on_stage(Progress(f"charging: {100 * self._senses.share:.0f} %", self._senses.share))
        finally:
            self._senses.mode = Mode.RESTING

    def _dock(self, permit: Permit, on_stage: OnStage) -> int:
        """Move until current flows; return how many tries failed."""
        self._tried, self._sightings = [], 0
        failed = 0

        def act(free: Permit) -> None:
            nonlocal failed
            self._senses.find = True
            while failed < TRIES and not self._senses.charging:
                if not self._searched(free, on_stage):
                    continue
                failed += self._approached(free, on_stage)

        try:
            self._wheels.during(permit, Mode.DOCKING, act)
        finally:
            self._brain.keep_aim(None)
            self._brain.post(Forget())
        return failed

    def _searched(self, permit: Permit, on_stage: OnStage) -> bool:
        """Go to the next place from where the dock was seen and look round; tell whether the dock is seen now."""
        tried = tuple(self._tried)
        answer = self._brain.call(lambda n: AimAtDock(n, tried))
        if answer.refusal:
            on_stage(Progress("looking for the dock"))
            self._tried = []
            return self._sought(permit, None, ROAM_S)
        place, seen = answer.experience, self._brain.newest
        on_stage(Progress("going to a place from where the dock was seen"))
        if seen is not None:
            self._brain.keep_aim(lambda n: Aim(n, seen.map_number, *seen.pose[:2], place))
        self._tried.append(place)
        if self._sought(permit, place, min(answer.limit_s, PLACE_S)) or self._looked_round(permit):
            return True
        now = self._brain.newest
        arrived = now is not None and now.guided is not None and now.guided.reached
        self._brain.post(Forget(place if arrived else NONE))
        return False

    def _sought(self, permit: Permit, place: int | None, seconds: float) -> bool:
        """Drive to a place, or roam without one, until the dock is seen or the time is over."""
        until = self._clock.monotonic() + seconds
        led = self._clock.monotonic()
        while self._clock.monotonic() < until and (place is None or self._clock.monotonic() - led < UNLED_S):
            seen = self._wheels.pause(permit)
            if self._senses.charging or self._visible(seen):
                return True
            if seen is None:
                led = self._clock.monotonic()  # a brain that is silent has not refused to lead there
            elif place is None:
                self._wheels.steer(None, permit, Mode.DOCKING)
            elif seen.guided is not None and seen.guided.goal == place:
                led = self._clock.monotonic()
                if seen.guided.reached:
                    return False
                self._wheels.steer(seen.guided.bearing, permit, Mode.DOCKING)
        return False

    def _looked_round(self, permit: Permit) -> bool:
        """Turn once on the spot; tell whether the dock came into sight."""
        until = self._clock.monotonic() + 2.2 * pi / TURN_RAD_S
        while self._clock.monotonic() < until:
            if self._visible(self._wheels.pause(permit)):
                return True
            self._wheels.drive(Velocity(0.0, TURN_RAD_S), permit)
        return False

    def _visible(self, seen: Seen | None) -> bool:
        """Tell whether the outer marker was seen in several successive pictures."""
        if seen is None or seen.at == self._seen_at:
            return False
        self._seen_at = seen.at
        near = seen.outer is not None and seen.outer.z < NEAR_M and abs(seen.outer.x) < ASIDE
        self._sightings = self._sightings + 1 if near else 0
        return self._sightings >= SURE

    def _approached(self, permit: Permit, on_stage: OnStage) -> int:
        """Follow the markers into the dock; return how many tries failed until it charged or the dock was lost."""
        memory, told = Docking(), -1
        while memory.phase not in ("charging", "gone") and memory.tries < TRIES:
            if memory.tries != told:
                told = memory.tries
                on_stage(Progress(f"docking, try {told + 1}"))
            seen = self._wheels.pause(permit)
            outer, small = self._sighted(seen)
            wanted, memory = dock(outer, small, self._senses.charging, memory, STEP_S)
            self._wheels.drive(Velocity(wanted.v, wanted.w) if seen is not None else REST, permit)
        self._sightings = 0
        return memory.tries

    def _sighted(self, seen: Seen | None) -> tuple[Sighting | None, Sighting | None]:
        """Return the markers in the newest picture, none in an old one."""
        if seen is None or seen.picture == "none" or self._clock.monotonic() - seen.at > OLD_S + STEP_S:
            return None, None
        return seen.outer, seen.small
