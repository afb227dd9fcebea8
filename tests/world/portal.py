"""A world with the rows of the people side, a store, and one robot with its owner."""

import shutil
from datetime import timedelta
from functools import partial
from math import inf

import pytest
from django.conf import settings

from portal.live import store as live_store
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import RobotError
from robots.models import Command, Robot
from robots.prepared import Prepared, Slot
from robots.states import COMMAND_FINAL, Cycle, GrantKind
from tests.conftest import at_length
from tests.faults.wishes import ROBOTS
from tests.world.async_store import AsyncStore
from tests.world.controls import Controls, state_of
from tests.world.delays import NONE, Delays
from tests.world.irat import IratRig
from tests.world.mercury import MercuryRig
from tests.world.owner import Supervisor
from tests.world.pa10 import ArmRig
from tests.world.puma import PumaRig
from tests.world.srv1 import RoverRig
from tests.world.store import MemoryStore
from tests.world.world import World

RIGS = {
    "mercury": MercuryRig,
    "pa10": ArmRig,
    "puma": PumaRig,
    "irat": IratRig,
    "srv1": RoverRig,
    "errands": MercuryRig,
}
EACH = pytest.mark.parametrize("which", ["mercury", "pa10", "irat", *map(at_length, ("srv1", "puma"))], indirect=True)
ALL = pytest.mark.parametrize("which", ["mercury", "pa10", "irat", "srv1", at_length("puma")], indirect=True)
NEW = {  # a robot's row, as if no world had been before
    "cycle": Cycle.OFFLINE, "reason": "", "stop_latched": False, "releases": 0, "stopped_at": None,
    "stopped_after": None, "stop_confirmed": False, "rests_by": None, "settings": {},
}  # fmt: skip
_ROW: Prepared[Robot] = Prepared(lambda: Robot.objects.filter(pk=Slot("robot", Robot._meta.pk)))
_OPEN: Prepared[Command] = Prepared(lambda: Command.objects.exclude(state__in=COMMAND_FINAL).only("pk")[:1])
SPOTS = ((-0.2, 0.3), (0.19, 0.45), (0.0, 0.35))


class Portal:
    """What a test in virtual time begins with; `close` it before the next."""

    def __init__(self, seed: int, robot: Robot, people: dict, folder, delays: Delays = NONE) -> None:
        shutil.rmtree(settings.VAR / "run", ignore_errors=True)
        Robot.objects.filter(pk=robot.pk).update(**NEW)
        self.world, self.robot, self.people = World(seed, delays), robot, people
        self._moves = 0
        self.wishes, self.slug = ROBOTS[RIGS[robot.driver].driver], robot.slug
        self.store = MemoryStore(self.world)
        bus.speak_through(self.store)
        live_store.speak_through(partial(AsyncStore, self.store))
        self._before = SYSTEM.live_by(self.world)
        self.rig = RIGS[robot.driver](self.world, folder)
        self.supervisor = Supervisor(self.world, robot.slug, self.rig)
        self.controls = Controls(self.world)  # of held motions

    def close(self) -> None:
        try:
            self.world.close()
        finally:
            self.rig.close()
            SYSTEM.live_by(self._before)
            bus.speak_through(None)
            live_store.speak_through(None)

    # what is

    @property
    def owner(self):
        """Return the owner that has begun and lives; None while there is none."""
        return self.supervisor.owner

    @property
    def row(self) -> Robot:
        return _ROW(robot=self.robot.pk)[0]

    @property
    def moved_until(self) -> float:
        """Return when the robot came to rest last (monotonic, s); now while it moves.

        A motion may be several with rests between them, so ask when its command is over.
        """
        if self.rig.moving:
            return self.world.monotonic()
        return max((record["t"] for record in self.rig.journal() if record["event"] == "rest"), default=-inf)

    def motions(self) -> list[dict]:
        """Return the motions that commands began, as the simulator noted them."""
        return self.wishes.motions(self.rig.journal())

    def until(self, holds, seconds: float, what: str):
        return self.world.until(holds, seconds, what)

    # what people do

    def ready(self) -> None:
        """Wait until the robot could be offered."""
        self.until(lambda: self.row.cycle == Cycle.READY, 180, "a robot that is in order")

    def grant(self, seconds: float = 9 * 3600.0) -> None:
        """Give ada the robot, once it is ready; after the turn before it is handed over."""
        Robot.objects.filter(pk=self.robot.pk, cycle=Cycle.OPERATING).update(cycle=Cycle.HANDOVER)
        self.ready()
        Robot.objects.filter(pk=self.robot.pk).update(cycle=Cycle.OPERATING)
        now = self.world.now()
        services.start_grant(self.robot, GrantKind.TURN, now, self.people["ada"], now + timedelta(seconds=seconds))

    def issue(self, kind: str, wake: bool = True, **args: float) -> Command:
        """Ask for a command in the words of all robots; see `tests.faults.wishes`."""
        kind, args = self.wishes.spell(kind, args, None)
        grant = services.open_grant(self.robot)
        return services.issue(self.slug, self.people["ada"], kind, args, services.next_seq(grant)).command

    def place(self) -> dict[str, float]:
        """Return a place where no motion before went."""
        number, self._moves = self._moves, self._moves + 1
        x, y = SPOTS[number % len(SPOTS)]
        return {"x": round(x + 0.0002 * (number % 200), 4), "y": round(y + 0.0005 * (number // 600), 4)}

    def move(self) -> Command:
        """Ask for a motion to a place where no motion before went."""
        return self.hold_if_held(self.issue("move", **self.place()))

    def hold_if_held(self, command: Command) -> Command:
        """Hold the controls for a command that goes on for as long as somebody does."""
        return self.controls.hold(command) if self.robot.spec().command(command.kind).held else command

    def ready_again(self, seconds: float = 60.0) -> None:
        """Wait until the robot is connected and its turn goes on."""
        self.until(lambda: self.owner and self.owner.connection.connected, seconds, "the connection")

    def works_on(self, seconds: float = 60.0) -> None:
        """Ask for motions until one is completed, at most so many seconds."""
        end = self.world.monotonic() + seconds
        said = ""
        while self.world.monotonic() < end:
            try:
                command = self.final(self.move())
            except RobotError as error:
                said = str(error)
            else:
                said = f"{command.state}: {command.reason}"
                if command.state == "completed":
                    return
            self.world.sleep(0.5)
        raise AssertionError(f"nothing moves again: {said}")

    def final(self, command: Command, seconds: float = 90.0) -> Command:
        """Wait for the end of a command."""
        self.until(lambda: state_of(command) in COMMAND_FINAL, seconds, f"the end of {command.kind}")
        command.refresh_from_db()
        return command

    def all_final(self, seconds: float = 90.0) -> None:
        self.until(lambda: not _OPEN(), seconds, "every end")

    def in_motion(self) -> None:
        self.until(lambda: self.rig.moving, 30, "a motion")

    def at_rest(self, seconds: float = 10.0) -> None:
        self.until(lambda: not self.rig.moving, seconds, "rest")

    def stop(self) -> float:
        """Press Stop; return how long it took to rest (s)."""
        at = self.world.monotonic()
        bus.send_stop(self.slug)
        self.at_rest()
        return self.world.monotonic() - at

    def release(self) -> None:
        """Release the stop once its row is written."""
        self.until(lambda: self.row.stop_latched, 10, "the row of the stop")
        services.release_stop(self.robot, self.people["ada"], checked=True)
        self.until(lambda: self.owner and not self.owner.latch.latched, 10, "the release")
