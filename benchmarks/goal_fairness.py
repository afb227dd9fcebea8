"""How fairly goals are shared out by 50 people, one of whom clicks all the time with a new cookie each time.

The portal's own services run on a clock of their own; a goal takes 20 s. A person clicks about a minute after the last goal
ended or was refused. The greedy one clicks each second. Beside it the same people at a bounded FIFO of 10, which serves
who comes first. Judged by Jain's index of goals reached: 1 if all get as many, 1/50 if one gets everything.
"""

import random
from collections import Counter, deque
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from unittest.mock import patch

from benchmarks.stage import database, set_up, tell

PEOPLE, HOURS, GOAL_S, PAUSE_S, BOUND = 50, 4, 20, 60.0, 10
GREEDY = 0
GOAL = 0.95


def jain(served: Counter[int]) -> float:
    """Return Jain's index of fairness over all people."""
    each = [served[person] for person in range(PEOPLE)]
    return sum(each) ** 2 / (PEOPLE * sum(one * one for one in each)) if any(each) else 0.0


def crowd(click: Callable[[int, int], bool], serve: Callable[[int], int | None]) -> Counter[int]:
    """Let everybody click for `HOURS`; return how many goals each got.

    `click` (person, second) tells whether the goal was taken; `serve` (second) returns whose goal has just ended.
    """
    dice, served = random.Random(1), Counter[int]()
    due = {person: dice.expovariate(1 / PAUSE_S) for person in range(PEOPLE)}
    for second in range(HOURS * 3600):
        done = serve(second)
        if done is not None:
            served[done] += 1
            due[done] = second + dice.expovariate(1 / PAUSE_S)
        due[GREEDY] = second
        for person in sorted(range(PEOPLE), key=lambda _: dice.random()):
            if due[person] > second:
                continue
            taken = click(person, second)
            due[person] = float("inf") if taken else second + dice.expovariate(1 / PAUSE_S)
    return served


def first_come() -> Counter[int]:
    """Return what a bounded FIFO gives to each."""
    waiting: deque[int] = deque()
    until = 0

    def click(person: int, _: int) -> bool:
        if len(waiting) >= BOUND:
            return False
        waiting.append(person)
        return True

    def serve(second: int) -> int | None:
        nonlocal until
        if not waiting or second < until:
            return None
        until = second + GOAL_S
        return waiting.popleft()

    return crowd(click, serve)


def fair() -> Counter[int]:
    """Return what the portal's queue gives to each: guests, each at an address of their own."""
    from queueing import services as queue
    from queueing.errors import TooManyJobs
    from queueing.models import Job, JobState, QueueRobot
    from queueing.services import Asker, ask
    from robots.models import Command, Lease, Robot
    from robots.states import CommandState, Cycle
    from workers.commands import rows

    begun = datetime(2026, 1, 1, tzinfo=UTC)
    robot = Robot.objects.create(slug="irat", name="iRat", driver="irat", address="sim:irat", enabled=True)
    queue.queue_of(robot)
    Lease.objects.create(robot=robot, epoch=1, expires_at=begun + timedelta(days=9))
    Robot.objects.update(cycle=Cycle.READY)
    QueueRobot.objects.update(
        offers_turns=False, guests_ask=True, charged_in="jobs", rest_after_min=1, watched_at=begun - timedelta(days=1)
    )
    clicks = Counter[int]()
    since: dict[int, int] = {}

    def click(person: int, second: int) -> bool:
        clicks[person] += 1
        cookie = f"{person:04d}{clicks[person]:060d}"
        asker = Asker(guest=cookie, network=f"192.0.2.{person + 1}")
        try:
            ask(robot, asker, "goal", {"map": 1, "x": 0.1, "y": 0.1}, begun + timedelta(seconds=second))
        except TooManyJobs:
            return False
        return True

    def serve(second: int) -> int | None:
        now = begun + timedelta(seconds=second)
        running = Job.objects.filter(state=JobState.RUNNING).first()
        ended = None
        if running is not None and second - since.setdefault(running.pk, second) >= GOAL_S:
            command = Command.objects.select_related("robot", "grant").get(ended_at=None)
            rows.finish(command, CommandState.COMPLETED, now, "", {})
            ended = int(running.guest[:4])
        if running is None or ended is not None:
            queue.tick(now)
        return ended

    return crowd(click, serve)


def main() -> None:
    """Share out goals in both ways."""
    set_up()
    # nobody watches, so that the robot does not roam between two goals
    with database(), patch("robots.bus.may_be_watched", lambda _: False):
        ours = fair()
    plain = first_come()
    beside = {
        "bounded_fifo": round(jain(plain), 3), "goals": sum(ours.values()), "greedy": ours[GREEDY],
        "others": sorted(ours[p] for p in range(PEOPLE) if p != GREEDY)[:: PEOPLE // 5],
        "fifo_greedy": plain[GREEDY], "fifo_goals": sum(plain.values()),
    }  # fmt: skip
    tell("goal_fairness", jain(ours), "Jain's index", f">= {GOAL}", jain(ours) >= GOAL, beside)


if __name__ == "__main__":
    main()
