"""`make soak HOURS=n`: simulated people drive and watch both arms while faults are injected; prints slopes.

Memory, descriptors and threads of each process and unfinished commands, each fitted with a
straight line, an hour's slope a line; and the records that are stuck in the end. Processes are
killed in the first half alone, so that each lives through the second, which is what is fitted.
The same is written into `docs/reference/soak.md`.
"""

import json
import random
import sys
import threading
import time  # noqa: TID251 - no test
import urllib.request
from datetime import timedelta
from pathlib import Path

import numpy as np

from benchmarks.stage import cast, database, set_up

RECORD = [sys.executable, "-m", "workers.recorder"]

SAMPLE_S = 10.0
FAULT_S = 45.0
PAGE = Path(__file__).resolve().parent.parent / "docs" / "reference" / "soak.md"
REST_S = 75  # whatever is under way ends within this time
WARM_S, LEAST_SAMPLES = 120.0, 6  # a process grows while it begins; fewer samples tell nothing
VIEWERS = 2  # of each robot
WATCHED_S = (20.0, 120.0)
STRENGTHS = {"corrupt": 0.03, "drop": 0.03, "slow": 0.2, "disturb": 60.0}
BESIDE = {"mercury": "double_ack", "pa10": "slip"}  # those that the proofs know of
FOR_A_WHILE = ("corrupt", "drop", "slow")  # until the next fault; the others three times
KILLS = ("redis", "worker", "web", "recorder", "simulator")


def main() -> None:
    """Run for so many hours."""
    hours = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
    set_up()
    with database():
        Soak().run(hours * 3600)


class Stand:
    """One robot with its simulator, its owner and its people."""

    def __init__(self, robot, first, dice) -> None:
        from tests.faults.wishes import ROBOTS
        from tests.rig import worker

        self.robot, self.dice, self.wishes = robot, dice, ROBOTS[robot.driver]
        self.people = [first, *(self._person(i) for i in range(3))]
        self.sim = self.wishes.simulator(robot.rig_dir)
        self._begin = lambda: worker(robot.slug)
        self.worker = self._begin()
        self.done = {"commands": 0, "refused": 0, "turns": 0, "faults": 0}

    def _person(self, number: int):
        from accounts.models import Clearance, User
        from robots.kit.clock import SYSTEM

        name = f"{self.robot.slug}-{number}"
        person = User.objects.create_user(name, f"{name}@example.org", "correct horse 42")
        Clearance.objects.create(user=person, robot=self.robot, granted_at=SYSTEM.now())
        return person

    def look_after(self) -> None:
        if not self.worker.alive():
            self.worker = self._begin()

    def live(self) -> None:
        """Let each person do something, or nothing."""
        from queueing.errors import QueueError
        from robots.kit.contract.errors import RobotError

        for person in self.people:
            try:
                self._act(person)
            except (RobotError, QueueError):
                self.done["refused"] += 1

    def _act(self, person) -> None:
        from queueing import services as queue
        from robots import services
        from robots.kit.clock import SYSTEM
        from robots.models import Robot

        now = SYSTEM.now()
        queue.note_presence(self.robot, person, now, classic=False)
        ticket = queue.open_ticket(self.robot, person)
        if ticket is None:
            if self.dice.random() < 0.05:
                queue.join(self.robot, person, now)
        elif ticket.state == "offered":
            queue.accept(self.robot, person, now)
            self.done["turns"] += 1
        elif ticket.state == "operating":
            if Robot.objects.get(pk=self.robot.pk).stop_latched:
                services.release_stop(self.robot, person, checked=True)
            elif self.dice.random() < 0.01:
                services.stop(self.robot, person)
            elif self.dice.random() < 0.01:
                queue.leave(self.robot, person, now)
            else:
                self._command(person)

    def _command(self, person) -> None:
        from robots import services
        from robots.grants import grant_of
        from robots.kit.clock import SYSTEM
        from robots.models import Command
        from robots.states import COMMAND_FINAL

        if Command.objects.filter(robot=self.robot).exclude(state__in=COMMAND_FINAL).count() > 2:
            return
        kind = self.dice.choice(("move", "move", "up", "down", "air" if self.robot.driver == "mercury" else "program"))
        args: dict[str, float] = {}
        if kind == "move":
            args = {"x": self.dice.uniform(-0.2, 0.2), "y": self.dice.uniform(0.3, 0.5)}
        elif kind == "program":
            args = {"number": self.dice.choice((1.0, 2.0))}
        kind, args = self.wishes.spell(kind, args, None)
        grant = grant_of(self.robot, person, SYSTEM.now())
        services.issue(self.robot.slug, person, kind, args, services.next_seq(grant))
        self.done["commands"] += 1

    def fault(self) -> None:
        self.done["faults"] += 1
        self.sim.clear()
        verb = self.dice.choice((*self.wishes.faults, BESIDE[self.robot.driver]))
        self.sim.fault(verb, STRENGTHS.get(verb, 1.0), count=None if verb in FOR_A_WHILE else 3)

    def restart_simulator(self) -> None:
        self.sim.stop()
        self.sim.start()

    def close(self) -> None:
        self.worker.kill()
        self.sim.stop()


class Viewer(threading.Thread):
    """Somebody who opens a robot's page, watches for a while, goes, and comes back."""

    def __init__(self, slug: str, where, dice: random.Random) -> None:
        super().__init__(daemon=True)
        self.slug, self.where, self.dice = slug, where, dice
        self.packets = self.visits = 0
        self.running = True

    def run(self) -> None:
        while self.running:
            try:
                self._visit(self.where())
            except Exception:
                time.sleep(1)

    def _visit(self, url: str) -> None:
        from websockets.sync.client import connect

        urllib.request.urlopen(f"{url}/robots/{self.slug}/", timeout=10).read()
        until = time.monotonic() + self.dice.uniform(*WATCHED_S)
        with connect(f"{url.replace('http', 'ws')}/ws/robots/{self.slug}/", origin=url, max_size=None) as line:
            self.visits += 1
            while self.running and time.monotonic() < until:
                self.packets += isinstance(line.recv(timeout=20), bytes)


class Soak:
    """The whole portal under its own people."""

    def __init__(self) -> None:
        from robots.models import Records, Robot
        from tests.conftest import RedisServer
        from tests.rig import Child, Web, housekeeping

        self.dice = random.Random(42)
        self.redis = RedisServer()
        self.redis.start()
        mercury, ada = cast()
        self.stands = [Stand(robot, ada, self.dice) for robot in (mercury, self._museum_arm(ada))]
        Robot.objects.update(records=Records.WORK)
        self._web, self._housekeeper, self._recorder = Web, housekeeping, lambda: Child("recorder", RECORD)
        self.web, self.housekeeper, self.recorder = Web(), housekeeping(), self._recorder()
        self.viewers = [
            Viewer(stand.robot.slug, lambda: self.web.url, random.Random(n))
            for stand in self.stands
            for n in range(VIEWERS)
        ]
        self.samples: list[dict[str, float]] = []
        self.kills = dict.fromkeys(KILLS, 0)

    def _museum_arm(self, person):
        from accounts.models import Clearance
        from queueing.services import queue_of
        from robots.kit.clock import SYSTEM
        from robots.models import Robot

        robot = Robot.objects.create(slug="pa10", name="Museum arm", driver="pa10", address="sim:pa10", enabled=True)
        queue_of(robot)
        Robot.objects.update(turn_s=60)
        Clearance.objects.create(user=person, robot=robot, granted_at=SYSTEM.now())
        return robot

    def run(self, seconds: float) -> None:
        begun = time.monotonic()
        next_sample = next_fault = begun + 20
        half = begun + seconds / 2
        for viewer in self.viewers:
            viewer.start()
        try:
            while time.monotonic() - begun < seconds:
                now = time.monotonic()
                self._look_after()
                for stand in self.stands:
                    stand.live()
                if now >= next_sample:
                    self.samples.append(self._sample(now - begun))
                    next_sample = now + SAMPLE_S
                if now >= next_fault:
                    self._trouble(kill=now < half)
                    next_fault = now + FAULT_S / len(self.stands) * self.dice.uniform(0.5, 1.5)
                time.sleep(0.2)
            self._settle()
            self._report(seconds)
        finally:
            for viewer in self.viewers:
                viewer.running = False
            for stand in self.stands:
                stand.close()
            self.web.kill()
            self.housekeeper.kill()
            self.recorder.kill()
            self.redis.stop()

    def _look_after(self) -> None:
        """Start again what ended, as the supervisor does."""
        for stand in self.stands:
            stand.look_after()
        if not self.web.alive():
            self.web = self._web()
        if not self.housekeeper.alive():
            self.housekeeper = self._housekeeper()
        if not self.recorder.alive():
            self.recorder = self._recorder()

    def _settle(self) -> None:
        for stand in self.stands:
            stand.sim.clear()
        until = time.monotonic() + REST_S
        while time.monotonic() < until:
            self._look_after()
            time.sleep(1)

    def _trouble(self, kill: bool) -> None:
        """Break one thing of one robot, or something that all need."""
        stand = self.dice.choice(self.stands)
        if self.dice.random() >= 0.3 or not kill:
            stand.fault()
            return
        what = self.dice.choice(KILLS)
        self.kills[what] += 1
        match what:
            case "redis":
                self.redis.stop()
                time.sleep(2)
                self.redis.start()
            case "worker":
                stand.worker.kill()
            case "web":
                self.web.kill()
            case "recorder":
                self.recorder.kill()
            case _:
                stand.restart_simulator()

    def _processes(self) -> dict[str, int]:
        found = {"web": self.web.pid, "housekeeping": self.housekeeper.pid, "recorder": self.recorder.pid}
        for stand in self.stands:
            found |= {
                f"{stand.robot.slug}-worker": stand.worker.pid,
                f"{stand.robot.slug}-robot": stand.sim.process.pid,
            }
        return found

    def _sample(self, at: float) -> dict[str, float]:
        from robots.models import Command
        from robots.states import COMMAND_FINAL

        found = {"at": at}
        for name, pid in self._processes().items():
            proc = Path(f"/proc/{pid}")
            try:
                status = dict(line.split(":", 1) for line in (proc / "status").read_text().splitlines() if ":" in line)
                found |= {
                    f"{name} memory, MB": int(status["VmRSS"].split()[0]) / 1024,
                    f"{name} threads": float(status["Threads"]),
                    f"{name} descriptors": float(len(list((proc / "fd").iterdir()))),
                    f"{name} pid": pid,
                }
            except (OSError, KeyError):
                continue
        found["unfinished commands"] = Command.objects.exclude(state__in=COMMAND_FINAL).count()
        return found

    def _slopes(self) -> dict[str, dict[str, float]]:
        """Fit the second half, of each process as it was in the end and warm."""
        half = [s for s in self.samples if s["at"] > self.samples[-1]["at"] / 2]
        slopes = {}
        for key in sorted({k for s in half for k in s if k != "at" and not k.endswith("pid")}):
            process = f"{key.split()[0]} pid"
            now = half[-1].get(process)
            began = min((s["at"] for s in self.samples if s.get(process) == now), default=0.0) if now else -WARM_S
            points = [
                (s["at"], s[key]) for s in half if key in s and s.get(process) == now and s["at"] > began + WARM_S
            ]
            if len(points) >= LEAST_SAMPLES:
                slopes[key] = {
                    "an hour": round(float(np.polyfit(*zip(*points, strict=True), 1)[0]) * 3600, 2),
                    "first": round(points[0][1], 1),
                    "last": round(points[-1][1], 1),
                    "most": round(max(p[1] for p in points), 1),
                    "minutes": round((points[-1][0] - points[0][0]) / 60, 1),
                }
        return slopes

    def _report(self, seconds: float) -> None:
        stuck, slopes = self._stuck(), self._slopes()
        robots = {stand.robot.slug: self._story(stand) for stand in self.stands}
        for key, s in slopes.items():
            print(
                f"{key:>28}: {s['an hour']:+8.2f} an hour; {s['first']} to {s['last']}, at most {s['most']}, "
                f"in {s['minutes']} minutes"
            )
        print(json.dumps({"robots": robots, "kills": self.kills, "stuck": stuck}))
        self._write(seconds, robots, stuck, slopes)
        if any(stuck.values()):
            sys.exit("records are stuck")

    def _stuck(self) -> dict[str, int]:
        """Count what should have ended before the people went."""
        from queueing.models import Ticket, Turn
        from robots.kit.clock import SYSTEM
        from robots.models import Command, Grant
        from robots.states import COMMAND_FINAL

        old = SYSTEM.now() - timedelta(seconds=REST_S - 5)
        return {
            "commands": Command.objects.exclude(state__in=COMMAND_FINAL).filter(created_at__lt=old).count(),
            "grants past their end": Grant.objects.filter(ended_at=None, until__lt=old).count(),
            "turns past their end": Turn.objects.filter(ended_at=None, until__lt=old).count(),
            "offers past their end": Ticket.objects.filter(state="offered", offer_until__lt=old).count(),
        }

    def _story(self, stand: Stand) -> dict[str, int | str]:
        """Tell what happened at one robot."""
        from robots.models import Command, Incident, Robot
        from robots.states import COMMAND_FINAL

        commands, viewers = (
            Command.objects.filter(robot=stand.robot),
            [v for v in self.viewers if v.slug == stand.robot.slug],
        )
        return {
            **stand.done,
            **{str(state): commands.filter(state=state).count() for state in sorted(COMMAND_FINAL)},
            "incidents": Incident.objects.filter(robot=stand.robot).count(),
            "packets seen": sum(v.packets for v in viewers),
            "visits": sum(v.visits for v in viewers),
            "in the end": str(Robot.objects.get(pk=stand.robot.pk).cycle),
        }

    def _write(self, seconds: float, robots: dict, stuck: dict, slopes: dict) -> None:
        """Write the page."""
        from robots.kit.clock import SYSTEM
        from tests.proofs import machine

        kills = ", ".join(f"{what} {number}" for what, number in self.kills.items())
        lines = [
            "# Soak", "",
            f"Written by `make soak HOURS={seconds / 3600:g}` on {SYSTEM.now():%Y-%m-%d}; {machine()}. Simulated people "
            "drove and watched both arms while something was broken every half minute; processes were killed in the first half.", "",
            f"Killed and started again: {kills}. Stuck in the end: "
            + ", ".join(f"{what} {number}" for what, number in stuck.items()) + ".", "",
            "| | " + " | ".join(robots) + " |", "|---" * (len(robots) + 1) + "|",
        ]  # fmt: skip
        for key in next(iter(robots.values())):
            lines.append(f"| {key} | " + " | ".join(str(story[key]) for story in robots.values()) + " |")
        lines += [
            "", "Slopes over the second half of the run, in which nothing was killed, of each process that was warm:", "",
            "| | an hour | from | to | at most | over minutes |", "|---|---|---|---|---|---|",
        ]  # fmt: skip
        for key, s in slopes.items():
            lines.append(f"| {key} | {s['an hour']:+g} | {s['first']} | {s['last']} | {s['most']} | {s['minutes']} |")
        PAGE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
