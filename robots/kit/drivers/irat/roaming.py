"""Exploring, going to a goal, and leaving the dock."""

import contextlib
from collections.abc import Callable

from robots.kit.contract.errors import BadRequest, GaveUp, HardwareFault, RobotError
from robots.kit.contract.session import JSON, OnStage, Permit, Progress
from robots.kit.contract.values import number
from robots.kit.description import load
from robots.kit.drivers.irat.brain.messages import NONE, Aim, Answer, Clear, Forget
from robots.kit.drivers.irat.brain.places import MapCleared
from robots.kit.drivers.irat.brain.process import ANSWER_S
from robots.kit.drivers.irat.packets import Why
from robots.kit.drivers.irat.protocol import Velocity
from robots.kit.drivers.irat.senses import between
from robots.kit.drivers.irat.spec import SLICE_S, Mode
from robots.kit.drivers.irat.wheels import Wheels

EARLY_S = 3.0  # a slice ends by itself so long before its grant
BACK_M, BACK_M_S, BACK_S = 0.42, 0.10, 8.0  # out of the dock's funnel
ROUND_RAD, ROUND_RAD_S, ROUND_S = 2.6, 1.2, 5.0
CHARGES_S, COMES_S = 3 * 3600.0, 600.0  # how long a goal that was cut short keeps the map: to charge, otherwise
KNOWN_S = 3.0  # the oldest answer of the brain that tells the map's age: at rest one comes each second
UNLED_S = 2.0  # without guidance to the goal for so long, the goal is sent again


class Roaming:
    """The motions of everybody's goals and of idle hours."""

    def __init__(self, wheels: Wheels) -> None:
        self._wheels, self._brain, self._senses = wheels, wheels.brain, wheels.senses
        self._clock = wheels.clock
        described = load("irat")["map"]
        self._clear_s, self._latest_s = float(described["clear_s"]), float(described["clear_latest_s"])
        self._kept_until = -1e9  # a goal that was cut short may come again until then, and needs this map
        self._served_until = -1e9  # those who waited while the robot charged have their goals until then
        self._cleared = NONE  # the number of the map that was cleared last

    def explore(self, permit: Permit, on_stage: OnStage) -> JSON:
        """Roam for a slice."""
        until = self._clock.monotonic() + SLICE_S - EARLY_S
        self.clear_if_due()
        began = self._senses.driven

        def act(free: Permit) -> None:
            self.leave_dock(free, on_stage)
            while self._clock.monotonic() < until:
                if self._wheels.pause(free) is not None:
                    self._wheels.steer(None, free, Mode.EXPLORING)

        self._wheels.during(permit, Mode.EXPLORING, act)
        return {"driven": round(self._senses.driven - began, 3)}

    def clear_if_due(self) -> None:
        """Clear a map that is not pruned and old enough, where no goal waits; see `_clear_after`."""
        self._clear_after(self._clear_s, Why.AGE)

    def _clear_between_goals(self) -> None:
        """Clear a map that is so old that it is cleared although others may wait, unless these waited for a charge."""
        if self._clock.monotonic() >= self._served_until:
            self._clear_after(self._latest_s, Why.OLDEST)

    def _clear_after(self, seconds: float, why: Why) -> None:
        """Clear a map of this age (s), unless a goal that was cut short needs it.

        A brain that does not answer clears it another time.
        """
        seen = self._brain.fresh(KNOWN_S)
        if seen is None or seen.pruning or seen.age < seconds or seen.map_number == self._cleared:
            return
        if self._clock.monotonic() >= self._kept_until:
            with contextlib.suppress(HardwareFault):
                self._brain.call(lambda n: Clear(n, why))
                self._cleared = seen.map_number

    def charged(self) -> None:
        """Keep the map for the goals that waited for the charge, and no longer for one that was cut short."""
        self._served_until = self._clock.monotonic() + COMES_S
        self._kept_until = min(self._kept_until, self._served_until)

    def _cut_short(self, error: RobotError) -> None:
        """Keep the map for a goal that waits again: the robot has to charge, or had a fault.

        A cancel or a stop holds the robot in the same way as a need does; `low` tells them apart.
        """
        if self._senses.low:
            self._kept_until = self._clock.monotonic() + CHARGES_S
        elif isinstance(error, HardwareFault):
            self._kept_until = self._clock.monotonic() + COMES_S

    def leave_dock(self, permit: Permit, on_stage: OnStage) -> None:
        """Reverse out of the dock and turn round, if the charger's contacts are closed."""
        permit()
        on_stage("sent")
        on_stage("acknowledged")
        if not self._senses.charging:
            return
        for velocity, most, seconds in (
            (Velocity(-BACK_M_S, 0.0), BACK_M, BACK_S),
            (Velocity(0.0, ROUND_RAD_S), ROUND_RAD, ROUND_S),
        ):
            self._until(velocity, most, seconds, permit)

    def _until(self, velocity: Velocity, most: float, seconds: float, permit: Permit) -> None:
        """Drive with this velocity until the odometry has gone (m), or turned (rad), so far, or the time is over."""
        wheels, gone = self._wheels, 0.0
        was, until = wheels.line.odometry.value, self._clock.monotonic() + seconds
        while gone < most and self._clock.monotonic() < until:
            seen = wheels.pause(permit)
            here = wheels.line.odometry.value
            if was is not None and here is not None:
                distance, turn = between(was, here)
                gone += abs(distance) if velocity.linear else abs(turn)
            was = here
            if seen is not None:
                wheels.drive(velocity, permit)

    def goal(self, args: JSON, permit: Permit, on_stage: OnStage) -> JSON:
        """Go to a place of the map.

        Raises MapCleared, BadRequest for a place that is not on the map, GaveUp when the time for it is over.
        """
        permit()
        x, y, which = number(args, "x"), number(args, "y"), int(number(args, "map"))
        wanted = int(number(args, "experience")) if "experience" in args else NONE

        def aim(seconds: float) -> Answer:
            answer = self._brain.call(lambda n: Aim(n, which, x, y, wanted), seconds)
            if answer.refusal:
                raise (MapCleared if answer.cleared else BadRequest)(answer.refusal)
            return answer

        answer = aim(ANSWER_S)
        self._kept_until = -1e9  # a goal that was cut short is served first, so it is this one, or was cancelled
        self._brain.keep_aim(lambda n: Aim(n, which, x, y, answer.experience))
        over = False
        try:
            self._wheels.during(permit, Mode.GOAL, lambda free: self._go(which, answer, aim, free, on_stage))
            over = True
        except RobotError as error:
            self._cut_short(error)
            over = isinstance(error, GaveUp | BadRequest)  # after any other error it may wait again
            raise
        finally:
            self._brain.keep_aim(None)
            self._brain.post(Forget())
            if over:
                self._clear_between_goals()
        return {"experience": answer.experience, "map": which, "limit_s": round(answer.limit_s, 1)}

    def _go(self, which: int, aimed: Answer, aim: Callable[[float], Answer], permit: Permit, on_stage: OnStage) -> None:
        began, told = self._clock.monotonic(), 0.0
        goal, limit_s = aimed.experience, aimed.limit_s
        self.leave_dock(permit, on_stage)
        led = self._clock.monotonic()
        while True:
            spent = self._clock.monotonic() - began
            if spent > limit_s:
                raise GaveUp(f"The place was not reached within {limit_s:.0f} s, three times what the way takes.")
            seen = self._wheels.pause(permit)
            if seen is not None and seen.map_number != which:
                raise MapCleared("The map was cleared on the way, so this place is no longer known.")
            if seen is None:
                led = self._clock.monotonic()
                continue
            if seen.guided is None or seen.guided.goal != goal:
                if self._clock.monotonic() - led > UNLED_S:  # a restarted brain may have another experience there
                    led = self._clock.monotonic()
                    with contextlib.suppress(HardwareFault):
                        goal = aim(UNLED_S).experience
                continue
            led = self._clock.monotonic()
            if seen.guided.reached:
                return
            self._wheels.steer(seen.guided.bearing, permit, Mode.GOAL)
            if spent - told >= 1.0:
                told = spent
                on_stage(Progress(f"{spent:.0f} s of at most {limit_s:.0f} s", spent / limit_s))
