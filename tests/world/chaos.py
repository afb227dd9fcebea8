"""What happens to a portal while somebody drives its robot: faults and deaths, one beside the other, by a seed."""

import random
from dataclasses import dataclass, field

from robots import bus, services
from robots.kit.contract.errors import RobotError
from robots.models import Command, Grant
from robots.states import COMMAND_FINAL
from tests.world.delays import Delays
from tests.world.motions import Motions
from tests.world.portal import Portal

REST_S = 90.0  # within which everything is in order again, once nothing happens to it any more


def busy(seed: int) -> Delays:
    """Return the delays of a machine that is too busy."""
    return Delays(seed, share=0.01, mean_s=0.1, longest_s=1.5)


@dataclass
class Chaos:
    """One run: `doings` are the names of what may happen, beside the driving itself."""

    portal: Portal
    history: Motions = field(init=False)

    def __post_init__(self) -> None:
        self.world, self.dice = self.portal.world, random.Random(f"chaos {self.portal.world.seed}")
        self.history = Motions(self.portal)

    def run(self, steps: int, troubles: tuple[str, ...]) -> None:
        """Let so many things happen, then look whether everything comes into order again, and judge the history."""
        self.portal.grant()
        for _ in range(steps):
            if self.dice.random() < 0.55:
                self.drive()
            else:
                what = self.dice.choice(troubles)
                self.world.note(what)
                getattr(self, what)()
            self.world.sleep(self.dice.choice((0.0, 0.05, 0.3, 1.0, 4.0)) * self.dice.random())
        self.settle()
        self.history.check()

    def settle(self) -> None:
        """Mend everything; wait until the robot can be driven again."""
        portal, world = self.portal, self.world
        self.heal()
        portal.until(lambda: not self.unfinished(), REST_S, "the end of every command")
        for _ in range(30):
            if portal.row.stop_latched:
                self.release()
            command = self.drive()
            if command is not None and portal.final(command).state == "completed":
                return
            world.sleep(REST_S / 30)
        row = portal.row
        raise AssertionError(f"nothing moves again: {row.cycle}, {row.reason!r}, {self.last_error}")

    last_error = ""

    def unfinished(self) -> list[Command]:
        return list(Command.objects.exclude(state__in=COMMAND_FINAL))

    def heal(self) -> None:
        portal = self.portal
        portal.store.up, portal.store.silent, portal.store.copies = True, False, lambda channel: 1
        self.world.database_away = False
        portal.rig.plug()
        portal.rig.clear_faults()
        self.world.thaw(portal.supervisor.worker.process)

    # what people do

    def drive(self) -> Command | None:
        """Ask for the next motion; return its command, or None where it is refused."""
        try:
            if services.open_grant(self.portal.robot) is None:
                self.portal.grant()
            made = self.portal.move()
            self.history.issued[made.pk] = self.world.monotonic()
            return made
        except (RobotError, Grant.DoesNotExist) as error:
            self.last_error = str(error)
            return None

    def stop(self) -> None:
        bus.send_stop(self.portal.slug)

    def stop_by_row(self) -> None:
        try:
            services.stop(self.portal.robot, self.portal.people["ada"])
        except RobotError as error:
            self.last_error = str(error)

    def release(self) -> None:
        try:
            services.release_stop(self.portal.robot, self.portal.people["ada"], checked=True)
        except RobotError as error:
            self.last_error = str(error)

    # what happens to them

    def store_away(self) -> None:
        self.portal.store.up = False
        self.world.sleep(self.dice.random() * 5)
        self.portal.store.up = True

    def store_restarts(self) -> None:
        self.portal.store.restart()

    def store_silent(self) -> None:
        self.portal.store.silent = True
        self.world.sleep(self.dice.random() * 12)
        self.portal.store.silent = False

    def messages_lost_or_doubled(self) -> None:
        self.portal.store.copies = lambda channel: self.dice.choice((0, 1, 1, 2, 5))

    def database_away(self) -> None:
        self.world.database_away = True
        self.world.sleep(self.dice.random() * 6)
        self.world.database_away = False

    def cable_pulled(self) -> None:
        self.portal.rig.pull()
        self.world.sleep(self.dice.random() * 5)
        self.portal.rig.plug()

    def cable_stalls(self) -> None:
        self.portal.rig.stall(self.dice.random() * 3)

    def half_a_message(self) -> None:
        self.portal.rig.halve()

    def owner_frozen(self) -> None:
        worker = self.portal.supervisor.worker
        self.world.freeze(worker.process)
        self.world.sleep(self.dice.choice((0.3, 2.0, 8.0)) * self.dice.random())
        self.world.thaw(worker.process)

    def owner_killed(self) -> None:
        self.portal.supervisor.worker.kill()

    def owner_terminated(self) -> None:
        self.portal.supervisor.worker.terminate()

    def robot_switched_off(self) -> None:
        self.portal.rig.power_cycle()

    def robot_fails(self) -> None:
        verb = self.dice.choice(self.portal.rig.faults)
        self.portal.rig.fault(verb, self.portal.rig.strengths.get(verb, 1.0))
        self.world.sleep(self.dice.random() * 3)
        self.portal.rig.clear_faults()

    def clock_set(self) -> None:
        self.history.clock_set = True
        self.world.step(self.dice.choice((-3600.0, -5.0, 5.0, 3600.0)))

    def machine_sleeps(self) -> None:
        self.world.suspend(self.dice.choice((1.0, 10.0, 100.0)))


STOPS = ("stop", "stop", "stop_by_row", "release", "release")
STORES = ("store_away", "store_restarts", "store_silent", "messages_lost_or_doubled", "database_away")
WIRES = ("cable_pulled", "cable_stalls", "half_a_message", "robot_switched_off", "robot_fails")
DEATHS = ("owner_frozen", "owner_killed", "owner_killed", "owner_terminated")
CLOCKS = ("clock_set", "machine_sleeps")
EVERYTHING = STOPS + STORES + WIRES + DEATHS + CLOCKS
