"""The rules of every motion, judged at the moment at which the simulator begins it, and when a run is over."""

from collections import Counter
from math import inf

from robots.models import Command, Grant, Lease
from robots.services import START_S
from robots.states import COMMAND_FINAL
from tests.world.portal import Portal

WIRE_S = 0.4  # an instruction that was permitted is on its way for so long, at most
LOOK_S = 0.05


class Motions:
    """Watches one portal's robot. What cannot be is in `wrong`, and fails `check`."""

    look_s = LOOK_S

    def __init__(self, portal: Portal) -> None:
        self._portal, self._world = portal, portal.world
        self.wrong: list[str] = []
        self.begun: Counter[object] = Counter()  # by goal
        self._releases = 0  # of the robot's row when the stop was latched; more: it was released since
        self._latched_since, self._epoch_since, self._epoch = inf, -inf, 0
        self._wired_since = -inf  # since when the wire carries what it is given at once
        self.issued: dict[int, float] = {}  # commands, by when they were asked for (monotonic, s)
        self.clock_set = False
        portal.rig.tell(self._noted)
        observer = self._world.process("observer", delayed=False)
        portal.rig.process.judges = observer.judges = True  # the simulator's threads tell what is judged
        self._world.spawn(self._watch, "observer", observer)

    def _watch(self) -> None:
        """Note since when the robot's owner is stopped, and since when it is the owner."""
        while True:
            self._world.sleep(self.look_s)
            owner, now = self._portal.owner, self._world.monotonic()
            if owner is not None and not owner.latch.latched:
                self._latched_since = inf
            elif owner is not None and self._latched_since == inf:
                self._latched_since, self._releases = now, self._portal.row.releases
            if owner is not None and owner.lease.epoch != self._epoch:
                self._epoch, self._epoch_since = owner.lease.epoch, now

    def _noted(self, record: dict) -> None:
        """Judge a motion that begins now; called in the simulator's thread."""
        if record["event"] == "motion" and not self._portal.rig.is_by_itself(record):
            self._begins(record)

    def _begins(self, record: dict) -> None:
        goal = self._portal.wishes.made(record)
        self.begun[goal] += 1
        self._judge(goal)

    def _judge(self, goal: object) -> None:
        world, at = self._world, self._world.monotonic()
        same = [one for one in self.commands() if self._portal.wishes.goal(one) == goal]
        if not same:
            return  # the owner's own, to put the robot in order: judged by its grant
        command = same[0]  # the newest; a job that was put back has several
        named = f"motion {goal} of the command {command.pk} at {at:.3f} s"
        wire_s = WIRE_S + max(0.0, self._portal.rig.stalled_s)
        if self.begun[goal] > len(same):
            self.wrong.append(f"{named} is its {self.begun[goal]}th")
        if at - self._latched_since > wire_s and self._portal.row.releases == self._releases:
            self.wrong.append(f"{named} began {at - self._latched_since:.3f} s after a stop was latched")
        grant = Grant.objects.get(pk=command.grant_id)
        if (
            grant.ended_at is not None
            and (world.now() - grant.ended_at).total_seconds() > wire_s
            and not self.clock_set
        ):
            self.wrong.append(f"{named} began after its grant had ended at {grant.ended_at}")
        until = Lease.objects.get().expires_at
        if until is not None and (world.now() - until).total_seconds() > wire_s and not self.clock_set:
            self.wrong.append(f"{named} began after the lease of its owner had run out at {until}")
        if command.epoch < self._epoch and at - self._epoch_since > wire_s:  # a newer one begins before a look
            self.wrong.append(f"{named} is of the epoch {command.epoch}, and the owner's is {self._epoch}")
        asked = self.issued.get(command.pk, at)
        if at - asked > START_S + wire_s and not self.clock_set:
            self.wrong.append(f"{named} began {at - asked:.3f} s after it was asked for")

    def commands(self):
        return Command.objects.filter(kind__in=self._portal.wishes.moves)

    def check(self) -> None:
        """Judge what has become of every command. Fails with all that is wrong."""
        goals = Counter(self._portal.wishes.goal(command) for command in self.commands())
        for command in self.commands():
            goal = self._portal.wishes.goal(command)
            times = self.begun[goal]
            if command.state not in COMMAND_FINAL:
                self.wrong.append(f"{command.pk} is {command.state} in the end")
            elif command.state == "completed" and not 0 < times <= goals[goal]:
                self.wrong.append(f"{command.pk} is completed, and the robot began {times} such motions")
            elif command.state in ("rejected", "expired") and times >= goals[goal]:
                self.wrong.append(f"{command.pk} is {command.state}, and the robot moved: {command.reason}")
        if Grant.objects.filter(ended_at=None).count() > 1:
            self.wrong.append("more than one grant is open")
        assert not self.wrong, "\n".join(self.wrong)
        assert Lease.objects.get().epoch == self._portal.owner.lease.epoch
