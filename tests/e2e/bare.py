"""The web process over rows alone: for how pages look and behave, where no robot need move."""

import threading
import time  # noqa: TID251 - stamps of states
from datetime import timedelta
from pathlib import Path

import pytest
from django.conf import settings
from PIL import Image, ImageDraw

from accounts.models import Clearance, User
from operatorlog import services as log
from operatorlog.models import SurveyQuestion, Visibility
from portal.keep.seeding import SURVEY, add_robot
from queueing import services as queue
from queueing.models import Queue, Ticket, TicketState
from queueing.rows import announce
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.session import RobotState
from robots.kit.packets import state_packet
from robots.models import Command, Frame, Lease, Robot
from robots.states import CommandState, Cycle, GrantEnd
from tests.waiting import CEILING_S, wait_for
from workers.commands.rows import advance, finish

PASSWORD = "correct horse 42"
JOINTS = {"mercury": (0.9, 1.8, 0.0, 0.0), "pa10": (0.0, 0.44, 1.31, 0.0, 1.4, 0.0, 0.05)}
LASTS_S = 3600  # offers and turns, however busy the machine is
SIZES = {"mercury": (192, 165), "pa10": (320, 240)}


@pytest.fixture
def portal(bare):
    """The portal of a test file that imports this."""
    return bare


class BarePortal:
    """Robots in the database, as if their owners lived; joints are told again and again. `joints` (rad, m) by robot."""

    def __init__(self, web, joints=JOINTS):
        self.robots = {name: add_robot(name) for name in joints}
        self.robot = next(iter(self.robots.values()))
        self._joints = joints
        for robot in self.robots.values():
            Lease.objects.create(robot=robot, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
        Robot.objects.update(cycle=Cycle.READY, turn_s=LASTS_S)
        for position, (prompt, kind, options, low, high) in enumerate(SURVEY):
            SurveyQuestion.objects.create(
                prompt=prompt, kind=kind, options="\n".join(options), low_label=low, high_label=high, position=position
            )
        self.latched = False
        self._told = threading.Event()
        self._teller = threading.Thread(target=self._tell, daemon=True)
        self._teller.start()
        self.web = web
        self.url = web.url

    def _tell(self):
        number = 0
        while not self._told.wait(0.25):
            number += 1
            for name, joints in self._joints.items():
                rows = (tuple(0.0 for _ in joints),) * 2
                state = RobotState(time.monotonic(), joints, (0.0,) * 6, False, True, "", *rows, "READY")
                packet = state_packet(number, int(time.time() * 1000), state, self.latched)
                bus.publish_state(self.robots[name].slug, packet)
                bus.publish_compact(self.robots[name].slug, packet)  # a page on a busy machine asks for these

    def stop(self):
        self._told.set()
        self._teller.join()

    def person(self, name, *robots, **more):
        user = User.objects.create_user(name, f"{name}@example.org", PASSWORD, **more)
        for robot in robots:
            Clearance.objects.create(user=user, robot=self.robots[robot], granted_at=SYSTEM.now())
        return user

    def drive(self, user, robot):
        """Give the person a turn at the robot."""
        queue.join(self.robots[robot], user, SYSTEM.now())
        queue.tick(SYSTEM.now() + timedelta(seconds=1))
        turn = queue.accept(self.robots[robot], user, SYSTEM.now())
        for number in range(2):
            self.picture(robot, number, turn.grant)
        return turn

    def serve(self):
        """Advance the queues once somebody has joined, with nobody absent; an offer lasts."""
        wait_for(Ticket.objects.filter(state=TicketState.WAITING).exists, CEILING_S, "somebody who waits")
        now = SYSTEM.now()
        queue.tick(now, up_since=now)
        Ticket.objects.filter(state=TicketState.OFFERED).update(offer_until=now + timedelta(seconds=LASTS_S))
        for line in Queue.objects.all():
            announce(line)

    def perform(self):
        """End every command well, as an owner does; tell whether there was one."""
        waiting = list(Command.objects.filter(state=CommandState.QUEUED))
        for command in waiting:
            for state in (CommandState.ACCEPTED, CommandState.SENT, CommandState.ACKNOWLEDGED):
                advance(command, state, SYSTEM.now())
            finish(command, CommandState.COMPLETED, SYSTEM.now())
        return bool(waiting)

    def end(self, turn):
        queue.end_turn(turn, GrantEnd.STAFF, "ended by the operator", SYSTEM.now())
        Robot.objects.filter(pk=turn.robot_id).update(cycle=Cycle.READY)
        turn.refresh_from_db()
        return turn

    def picture(self, robot, number, grant=None):
        """Keep a picture with a circle in it, by which its proportions can be seen."""
        width, height = SIZES.get(robot, (320, 240))
        name = f"frames/{robot}-{number}-{time.monotonic_ns()}.jpg"
        path = Path(settings.MEDIA_ROOT) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        image = Image.new("RGB", (width, height), "#b9a06a")
        ImageDraw.Draw(image).ellipse((40, 40, 120, 120), fill="#573", outline="black")
        image.save(path)
        return Frame.objects.create(
            robot=self.robots[robot], grant=grant, taken_at=SYSTEM.now(), file=name, width=width, height=height,
            stable=True, pose=[0, 0.42, 0, 0], joints=list(self._joints[robot]),
        )  # fmt: skip

    def entry(self, user, robot, text="A burst of air left a hole beside the middle.", visibility=None):
        turn = self.end(self.drive(user, robot))
        made = log.write(turn, user, text, turn.grant.frames.first().pk, SYSTEM.now())
        if visibility == Visibility.FEATURED:
            type(made).objects.filter(pk=made.pk).update(visibility=visibility)
        return made
