"""`make soak HOURS=n`: simulated people drive while faults are sprinkled in; prints slopes.

Memory, descriptors and threads of each process, unfinished tasks and stuck records, each
fitted with a straight line over the second half of the run, an hour's slope a line.
"""

import json
import random
import sys
import time
from datetime import timedelta
from pathlib import Path

import numpy as np

from benchmarks.stage import database, set_up

SAMPLE_S = 10.0
FAULT_S = 45.0
VERBS = (("corrupt", 0.03), ("drop", 0.03), ("double_ack", 1.0), ("slow", 0.2), ("cam_freeze", 1.0), ("cam_flicker", 1.0), ("cam_gone", 1.0), ("awol", 1.0), ("power_cycle", 1.0), ("limit_hit", 1.0))  # fmt: skip
KILLS = ("redis", "worker", "web", "simulator")


def main() -> None:
    """Run for so many hours."""
    hours = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
    set_up()
    with database():
        Soak().run(hours * 3600)


class Soak:
    """The whole portal under its own people."""

    def __init__(self) -> None:
        from benchmarks.stage import cast
        from robots.models import Robot
        from tests.conftest import RedisServer
        from tests.rig import Simulator, Web, housekeeping, worker

        self.dice = random.Random(42)
        self.redis = RedisServer()
        self.redis.start()
        self.robot, ada = cast()
        Robot.objects.update(turn_s=60)
        self.people = [ada, *self._more_people(3)]
        self.sim = Simulator(self.robot.rig_dir)
        self._worker, self._web = worker, Web
        self.worker, self.web, self.broom = worker(), Web(), housekeeping()
        self.samples: list[dict[str, float]] = []
        self.done = {"commands": 0, "refused": 0, "turns": 0, "faults": 0, "kills": 0}
        self.seen = time.monotonic()

    def _more_people(self, number: int) -> list:
        from accounts.models import Clearance, User
        from robots.clock import SYSTEM

        made = [User.objects.create_user(f"p{i}", f"p{i}@example.org", "correct horse 42") for i in range(number)]
        for person in made:
            Clearance.objects.create(user=person, robot=self.robot, granted_at=SYSTEM.now())
        return made

    def run(self, seconds: float) -> None:
        begun = time.monotonic()
        next_sample = next_fault = begun + 20
        try:
            while time.monotonic() - begun < seconds:
                now = time.monotonic()
                self._look_after()
                self._people()
                if now >= next_sample:
                    self.samples.append(self._sample(now - begun))
                    next_sample = now + SAMPLE_S
                if now >= next_fault:
                    self._fault()
                    next_fault = now + FAULT_S * self.dice.uniform(0.5, 1.5)
                time.sleep(0.2)
            self.sim.clear()
            time.sleep(75)  # whatever is under way ends
            self._report()
        finally:
            for child in (self.worker, self.web, self.broom):
                child.kill()
            self.sim.stop()
            self.redis.stop()

    def _look_after(self) -> None:
        """Start again what ended, as the supervisor does."""
        from tests.rig import housekeeping

        if not self.worker.alive():
            self.worker = self._worker()
        if not self.web.alive():
            self.web = self._web()
        if not self.broom.alive():
            self.broom = housekeeping()

    def _people(self) -> None:
        from queueing import services as queue
        from queueing.errors import QueueError
        from robots import services
        from robots.clock import SYSTEM
        from robots.drivers.errors import RobotError
        from robots.models import Robot

        now = SYSTEM.now()
        for person in self.people:
            try:
                queue.seen(self.robot, person, now, classic=False)
                ticket = queue.open_ticket(self.robot, person)
                if ticket is None and self.dice.random() < 0.05:
                    queue.join(self.robot, person, now)
                elif ticket is not None and ticket.state == "offered":
                    queue.accept(self.robot, person, now)
                    self.done["turns"] += 1
                elif ticket is not None and ticket.state == "operating":
                    if Robot.objects.get(pk=self.robot.pk).stop_latched:
                        services.release_stop(self.robot, person, checked=True)
                    elif self.dice.random() < 0.01:
                        services.stop(self.robot, person)
                    elif self.dice.random() < 0.01:
                        queue.leave(self.robot, person, now)
                    else:
                        self._command(services, person)
            except (RobotError, QueueError):
                self.done["refused"] += 1

    def _command(self, services, person) -> None:
        from robots.models import Command
        from robots.states import COMMAND_FINAL

        if Command.objects.filter(robot=self.robot).exclude(state__in=COMMAND_FINAL).count() > 2:
            return
        kind = self.dice.choice(("move", "move", "up", "down", "air"))
        args = {"x": self.dice.uniform(-0.2, 0.2), "y": self.dice.uniform(0.3, 0.5)} if kind == "move" else {}
        grant = services.grant_of(self.robot, person, services.SYSTEM.now())
        services.issue("mercury", person, kind, args, services.next_seq(grant))
        self.done["commands"] += 1

    def _fault(self) -> None:
        self.done["faults"] += 1
        if self.dice.random() < 0.2:
            self.done["kills"] += 1
            match self.dice.choice(KILLS):
                case "redis":
                    self.redis.stop()
                    time.sleep(2)
                    self.redis.start()
                case "worker":
                    self.worker.kill()
                case "web":
                    self.web.kill()
                case _:
                    self.sim.stop()
                    self.sim.start()
            return
        self.sim.clear()
        verb, value = self.dice.choice(VERBS)
        self.sim.fault(verb, value, count=None if verb in ("corrupt", "drop", "slow") else 3)

    def _sample(self, at: float) -> dict[str, float]:
        from robots.models import Command
        from robots.states import COMMAND_FINAL

        found = {"at": at}
        for name, child in (("worker", self.worker), ("web", self.web), ("broom", self.broom)):
            proc = Path(f"/proc/{child.pid}")
            try:
                status = dict(line.split(":", 1) for line in (proc / "status").read_text().splitlines() if ":" in line)
                found |= {
                    f"{name} memory, MB": int(status["VmRSS"].split()[0]) / 1024,
                    f"{name} threads": float(status["Threads"]),
                    f"{name} descriptors": float(len(list((proc / "fd").iterdir()))),
                }
                found[f"{name} pid"] = child.pid
            except (OSError, KeyError):
                continue
        found["unfinished commands"] = Command.objects.exclude(state__in=COMMAND_FINAL).count()
        return found

    def _report(self) -> None:
        from queueing.models import Ticket, Turn
        from robots.clock import SYSTEM
        from robots.models import Command, Grant, Incident
        from robots.states import COMMAND_FINAL

        old = SYSTEM.now() - timedelta(seconds=70)
        stuck = {
            "commands": Command.objects.exclude(state__in=COMMAND_FINAL).filter(created_at__lt=old).count(),
            "grants past their end": Grant.objects.filter(ended_at=None, until__lt=old).count(),
            "turns past their end": Turn.objects.filter(ended_at=None, until__lt=old).count(),
            "offers past their end": Ticket.objects.filter(state="offered", offer_until__lt=old).count(),
        }
        half = [s for s in self.samples if s["at"] > self.samples[-1]["at"] / 2]
        slopes = {}
        for key in sorted({k for s in half for k in s if k not in ("at",) and not k.endswith("pid")}):
            name = key.split()[0]
            last = half[-1].get(f"{name} pid")
            points = [(s["at"], s[key]) for s in half if key in s and (last is None or s.get(f"{name} pid") == last)]
            if len(points) >= 6:
                slope = float(np.polyfit(*zip(*points, strict=True), 1)[0]) * 3600
                slopes[key] = {"an hour": round(slope, 2), "last": round(points[-1][1], 1), "points": len(points)}
                print(f"{key:>28}: {slope:+8.2f} an hour, {points[-1][1]:.1f} at the end ({len(points)} samples)")
        states = {s: Command.objects.filter(state=s).count() for s in sorted(COMMAND_FINAL)}
        print(
            json.dumps(
                {
                    "done": self.done,
                    "states": states,
                    "incidents": Incident.objects.count(),
                    "stuck": stuck,
                    "slopes": slopes,
                }
            )
        )
        if any(stuck.values()):
            sys.exit("records are stuck")


if __name__ == "__main__":
    main()
