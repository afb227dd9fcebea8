"""A round with two pieces of rare names, and reports of the operator of an ended turn."""

from datetime import timedelta

from django.core.cache import cache
from django.test import Client

from operatorlog import finds
from operatorlog.finds import Report
from operatorlog.models import Find, Piece, Round
from queueing import services as queue
from queueing.models import Turn
from robots.kit.clock import SYSTEM
from robots.models import Frame
from robots.states import GrantEnd

AT = (0.1, 0.4, 0.0, 0.0)
SECRET = {"zirconium spoon": (-0.1234, 0.3217), "quartz thimble": (0.1987, 0.5123)}


def bed_of(robot):
    """Return a round with two pieces of rare names, and the ended turn of the operator with a picture."""
    cache.clear()
    turn = Turn.objects.get()
    picture(turn)
    queue.end_turn(turn, GrantEnd.FINISHED, "", SYSTEM.now())
    made = Round.objects.create(robot=robot, number=1, began_at=turn.started_at - timedelta(days=1))
    for name, (x, y) in SECRET.items():
        Piece.objects.create(round=made, name=name, x=x, y=y)
    return made


def picture(turn, pose=AT, file="frames/mercury/a.jpg"):
    return Frame.objects.create(robot=turn.robot, grant=turn.grant, taken_at=SYSTEM.now(), pose=list(pose), file=file)


def ended():
    return Turn.objects.select_related("robot", "grant", "user").get()


def reported(roles, name="a spoon", **more):
    turn = ended()
    return finds.report(turn, roles["operator"], Report(name, turn.grant.frames.first().pk, **more), SYSTEM.now())


def confirmed(roles, name="a spoon", piece="zirconium spoon"):
    find = reported(roles, name)
    finds.decide(find, roles["superuser"], Find.State.CONFIRMED, Piece.objects.get(name=piece), SYSTEM.now())
    return find


def as_role(roles, role):
    client = Client()
    if role != "anonymous":
        client.force_login(roles[role])
    return client


PAGES = (
    "/", "/log/", "/robots/mercury/", "/robots/mercury/finds/", "/status/", "/robots/mercury/recordings/", "/me/",
    "/robots/mercury/programs/", "/robots/mercury/orientation/", "/classic/mercury/x/", "turn",
)  # fmt: skip
