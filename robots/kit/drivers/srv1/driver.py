"""The hall rover's driver: by hand, to a place, in place, on patrol by its own rules, and on missions."""

import contextlib
from collections.abc import Callable
from pathlib import Path

from robots.kit.contract.errors import ControllerRefused, GaveUp, LineSilent, RobotError
from robots.kit.contract.session import JSON, OnStage, Outcome, Permit, Progress, RobotState, Session, Trace
from robots.kit.contract.values import check, number
from robots.kit.description import load
from robots.kit.drivers.permits import until_held
from robots.kit.drivers.srv1.alone import Alone
from robots.kit.drivers.srv1.extension import Activate
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.line import RoverLine
from robots.kit.drivers.srv1.locating import Locating
from robots.kit.drivers.srv1.motions import Motions
from robots.kit.drivers.srv1.pictures import Pictures
from robots.kit.drivers.srv1.refusals import StockFirmware
from robots.kit.drivers.srv1.rules import canonical, crc_of
from robots.kit.drivers.srv1.spec import SLICE_S
from robots.kit.drivers.srv1.stock import StockRover
from robots.kit.drivers.srv1.touring import go_to, observer, tour
from robots.kit.drivers.srv1.unseen import Unseen
from robots.kit.drivers.srv1.wheels import REST_S, Wheels
from robots.kit.drivers.stream import open_stream

NOTICED_S = 0.1  # the rover notices the end of a connection within this time
EARLY_S = 3.0  # a patrol ends by itself so long before its grant
UPLOADS = 3  # attempts: an upload moves nothing, and a motion that ends beside it ends it, too
NOT_WHOLE = "The rules did not reach the rover whole; those that were in force still are."


class Driver(Session):
    """A `robots.kit.contract.session.Session`. `settings` may hold `epoch`."""

    opened = staticmethod(open_stream)  # how a connection is opened

    def __init__(self, address: str, settings: JSON, trace: Trace | None = None) -> None:
        super().__init__(address, settings, trace)
        line = RoverLine(address, int(settings.get("epoch") or 1), trace, self.clock, self.opened)
        folder = settings.get("folder")
        alone_s = float(settings.get("permit_s", load("srv1")["line"]["permit_s"]))
        alone = Alone(line, alone_s, self.time_left, self.clock)
        file = Path(folder) / "whereabouts.json" if folder else None
        unseen = Unseen(line, lambda data: self.stream("unseen", data))
        self.wheels = Wheels(line, alone, unseen, self.keep, self.clock, file)
        self._motions = Motions(self.wheels)
        beacon = settings.get("beacon", hall().beacon)
        self._pictures = Pictures(line)
        self._locating = Locating(self._motions, hall().tower if beacon else None)
        self._stock: StockRover | None = None  # where the rover has its maker's firmware

    def connect(self) -> RobotState:
        """Open the line and claim the rover; one with its maker's firmware cannot be claimed."""
        self._stock = None
        try:
            return self.wheels.connect()
        except StockFirmware:
            self._stock = StockRover(self.wheels.line, self.keep, self.clock)
            return self._stock.connect()

    def recover(self, permit: Permit) -> RobotState:
        """Connect anew, when the rover has noticed that the connection before has ended: it takes one client."""
        permit()
        self.close()
        self.clock.sleep(NOTICED_S)
        return self.connect()

    def state(self) -> RobotState:
        """Ask the rover."""
        if self._stock is not None:
            return self._stock.state()
        self.wheels.ask()
        state = self.latest()
        assert state is not None
        return state

    def execute(self, kind: str, args: JSON, permit: Permit, on_stage: OnStage) -> Outcome:
        """Run one command to its end."""
        check("srv1", kind, args, self.settings, self.latest())
        stages, motions, locating = Stages(on_stage), self._motions, self._locating
        began, tell = stages.began, stages.tell
        if self._stock is not None:
            self._stock.refuse(kind)
            self._stock.drive(lambda: self._wanted(args), permit, began)
        if kind == "rules":
            crc = put_in_force(str(args["text"]), self.wheels, permit, began)
            return Outcome({"crc": crc}, self.latest())
        permit = until_held(permit, lambda: self.wheels.holds)  # also while a picture is taken, or nothing moves

        def drive() -> JSON:
            motions.drive(lambda: self._wanted(args), permit, began)
            return {}

        def go() -> JSON:
            def left(metres: float, share: float) -> None:
                tell(f"{metres:.1f} m to go", share)

            place = number(args, "x"), number(args, "y")
            return {"metres": round(go_to(place, motions, locating, permit, began, left, tell), 2)}

        def turn() -> JSON:
            motions.turn(number(args, "angle"), permit, began)
            return {}

        def patrol() -> JSON:
            until = self.clock.monotonic() + SLICE_S - EARLY_S
            if locating.is_unsure:
                tell("looks where it is")
                locating.look(permit, began)  # whether it finds it or not, it goes on
                tell("on patrol")
            return {"metres": round(motions.patrol(until - self.clock.monotonic(), permit, began, tell), 2)}

        def look() -> JSON:
            locating.find(permit, began, tell, observer(self._pictures, on_stage))
            return {"spread": round(self.wheels.where.spread, 2)}

        def mission() -> JSON:
            return tour(str(args["text"]), motions, locating, self._pictures, permit, began, on_stage)

        does: dict[str, Callable[[], JSON]] = {
            "drive": drive, "go": go, "turn": turn, "patrol": patrol, "look": look, "mission": mission
        }  # fmt: skip
        sent = {name: value for name, value in args.items() if name != "text"} | does[kind]()
        with contextlib.suppress(RobotError):  # it was done; whether the rover answers now is another matter
            return Outcome(sent, self.wheels.rest(REST_S))
        return Outcome(sent, self.latest())

    def _wanted(self, args: JSON) -> tuple[float, float]:
        """Return the shares ahead and to the left that are wanted now."""
        newest = self.steered(args)
        check("srv1", "drive", newest, self.settings, None)
        return number(newest, "forward"), number(newest, "turn")

    def rests_within(self) -> float | None:
        """Return within how many seconds it rests where it has a permit."""
        return self.wheels.alone.rests_within or None

    def picture(self, view: str, seconds: float) -> bytes | None:
        """Return the next picture of the rover's camera, None where it has none or the line is lost or too slow."""
        return self._pictures.take(seconds)

    def hold(self) -> RobotState:
        """Hold at once; return when the rover says that it rests."""
        if self._stock is not None:
            return self._stock.hold()
        self.wheels.holds += 1
        self.wheels.line.hold()
        return self.wheels.rest(REST_S)

    def close(self) -> None:
        """Close the connection; the rover rests."""
        self.wheels.close()


class Stages:
    """Tells the stages of one command in their order: its progress is told only once the rover has understood it."""

    def __init__(self, on_stage: OnStage) -> None:
        self._on_stage, self._begun = on_stage, False
        self._waits: Progress | None = None

    def began(self) -> None:
        """Tell that the rover has understood; only the first call counts."""
        if self._begun:
            return
        self._begun = True
        self._on_stage("sent")
        self._on_stage("acknowledged")
        if self._waits is not None:
            self._on_stage(self._waits)

    def tell(self, words: str, share: float | None = None) -> None:
        """Tell the progress."""
        if self._begun:
            self._on_stage(Progress(words, share))
        else:
            self._waits = Progress(words, share)


def put_in_force(text: str, wheels: Wheels, permit: Permit, began: Callable[[], None]) -> int:
    """Put a rule set into force while the rover does whatever it does; return its CRC.

    The rover drives by it from its next tick on. A hold by another thread ends an upload, which is begun again where
    `permit` allows it. Raises what `permit` and the line raise; GaveUp where the rover answers but does not get or take
    the text.
    """
    data, crc = canonical(text).encode("ascii"), crc_of(text)
    for _ in range(UPLOADS):
        permit()
        try:
            wheels.line.upload(data, permit)
            began()
            wheels.line.ask(Activate(wheels.line.epoch, crc), permit=permit)
        except LineSilent:
            continue
        except ControllerRefused as error:
            raise GaveUp(str(error)) from error
        else:
            wheels.ask()
            return crc
    wheels.ask()
    raise GaveUp(NOT_WHOLE)
