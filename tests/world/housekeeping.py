"""The housekeeping worker and the web process of a world: what runs beside people and robots."""

import math
from collections import defaultdict

from celery import current_app
from django.conf import settings

import queueing.tasks
import workers.process.tasks
from portal.run import uptime
from robots.bus import web_uptime
from robots.wall_clock import wall_clock
from tests.world.world import DatabaseAway, World


def by_queue() -> dict[str, list[dict]]:
    """Return the entries of Celery's schedule by the queue that they are sent to; tasks of pages move no robot."""
    found = defaultdict(list)
    for entry in settings.CELERY_BEAT_SCHEDULE.values():
        if not entry["task"].startswith(("queueing.", "robots.")):
            continue
        queue = entry.get("options", {}).get("queue", settings.CELERY_TASK_DEFAULT_QUEUE)
        found[queue].append(entry)
    return dict(found)


class Housekeeping:
    """One process of the worker that runs the schedule: each queue has a thread, as its pool has.

    What a process keeps to itself begins anew with it.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        wall_clock.cache_clear()
        queueing.tasks.ticking.cache_clear()
        workers.process.tasks.count_from_now()
        self.process = world.process("housekeeping")
        for queue, entries in sorted(by_queue().items()):
            world.spawn(lambda entries=entries: self._run(entries), f"housekeeping {queue}", self.process)

    def _run(self, entries: list[dict]) -> None:
        begun = self.world.awake()
        due = [begun + entry["schedule"] for entry in entries]
        while True:
            number = min(range(len(entries)), key=due.__getitem__)
            entry, at = entries[number], due[number]
            self.world.sleep(at - self.world.awake())
            late_s = self.world.awake() - at
            due[number] = self.world.awake() + entry["schedule"]
            if late_s <= entry.get("options", {}).get("expires", math.inf):
                self._carry_out(entry["task"])

    def _carry_out(self, task: str) -> None:
        """Run a task as a function; only an outage of the database may end it with an error."""
        try:
            current_app.tasks[task].run()
        except DatabaseAway:
            self.world.note(f"{task} found no database")


class Web:
    """The web process: while it is `up`, people reach the portal, and the queues are told so."""

    def __init__(self, world: World) -> None:
        self.world, self.up = world, True
        world.spawn(self._run, "web uptime", world.process("web"))

    def _run(self) -> None:
        while True:
            if self.up:
                uptime.tell()
            self.world.sleep(web_uptime.TELL_S)
