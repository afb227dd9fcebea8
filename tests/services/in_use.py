"""A portal in use: three robots, with a row of everything that staff see in the admin."""

from datetime import timedelta

from allauth.account.models import EmailAddress
from django.contrib.auth.models import Group, Permission

from accounts.models import Attempt, Clearance
from accounts.services import begin, load_bank, mark_read
from operatorlog import services as log
from operatorlog.models import Find, HidingReason, SurveyQuestion
from portal.web.alerts.models import Alert, AlertMessage
from queueing import services as queue
from queueing.models import JobRun, LostConnection, Ticket, Turn
from queueing.services import Asker, ask
from robots.grants import end_grant, start_grant
from robots.models import Command, Frame, Incident, Lease, Movie, Program, RecordingState, Records, Robot, Usage
from robots.recordings import keeping
from robots.states import CommandState, GrantEnd, GrantKind
from tests.services.turns import drive

BOX = {"name": "the vase", "low": [0.4, 0.1, 0.0], "high": [0.6, 0.3, 0.3]}
GOAL = {"map": 1, "x": 0.5, "y": 0.5}
DRIVEN = {"battery": 11.5, "charge": 50.0, "driven": 3.0, "map": 1.0}


def questions():
    """Return a question of each kind, asked after turns and jobs."""
    told = (("How was it?", "scale", ""), ("Real?", "choice", "Yes\nNo\nNot sure"), ("What for?", "text", ""))
    return [
        SurveyQuestion.objects.create(prompt=prompt, kind=kind, options=options, position=n)
        for n, (prompt, kind, options) in enumerate(told)
    ]


def driven(robot, person, now, minutes=3):
    """Return an ended turn with a command, two stored pictures and a recording."""
    turn = drive(robot, person, now)
    command = Command.objects.create(
        robot=robot, grant=turn.grant, client_seq=1, issued_by=person, kind="move", args={"x": 0.1}, epoch=1,
        state=CommandState.COMPLETED, created_at=now, accepted_at=now, ended_at=now, deadline=now,
    )  # fmt: skip
    for n in range(2):
        Frame.objects.create(
            robot=robot, grant=turn.grant, command=command, taken_at=now, file=f"frames/{robot.slug}/{turn.pk}-{n}.jpg",
            pose=[0.1, 0.2, 0.0], joints=[0.0] * 4, stable=True, verdict="still", width=193, height=164,
        )  # fmt: skip
    recording = keeping.begin(turn.grant, "here", now)
    keeping.finish(recording, RecordingState.READY, "", now + timedelta(minutes=minutes))
    Movie.objects.create(robot=robot, recording=recording, kind="mp4", state="ready", asked_at=now, ready_at=now)
    queue.end_turn(turn, GrantEnd.HOLDER, "ended by the operator", now + timedelta(minutes=minutes))
    Robot.objects.filter(pk=robot.pk).update(cycle="ready")
    turn.refresh_from_db()
    return turn


def running(job, now, state=CommandState.ACKNOWLEDGED, **more):
    """Let a job run, with a command in this state; return its grant."""
    grant = start_grant(job.robot, GrantKind.JOB, now, job.user)
    JobRun.objects.create(job=job, grant=grant)
    Command.objects.create(
        robot=job.robot, grant=grant, client_seq=1, issued_by=job.user, kind=job.kind, args=job.args, epoch=1,
        state=state, created_at=now, deadline=now, **more,
    )  # fmt: skip
    type(job).objects.filter(pk=job.pk).update(state="running")
    return grant


def job_done(robot, person, now, goal=GOAL):
    """Return a job that ended well, with the channels that statistics count."""
    job = ask(robot, Asker(user=person), "goal", goal, now, name="A walker")
    grant = running(job, now, state=CommandState.COMPLETED, ended_at=now, accepted_at=now,
        result={"channels": {"began": DRIVEN, "ended": DRIVEN | {"driven": 4.5}}, "sent": {"x": 0.5}},
        progress={"text": "half way", "share": 0.5},
    )  # fmt: skip
    end_grant(grant, GrantEnd.FINISHED, "done", now)
    type(job).objects.filter(pk=job.pk).update(state="done", ended_at=now, charged=1.0)
    recording = keeping.begin(grant, "here", now)
    keeping.finish(recording, RecordingState.READY, "", now)
    return job


def in_use(mercury, people, now):
    """Make the rows."""
    ada, bob, eve = (people[name] for name in ("ada", "bob", "eve"))
    pa10 = Robot.objects.create(
        slug="pa10", name="Arm", driver="pa10", address="sim:pa10", enabled=True, cycle="ready", records=Records.WORK,
        settings={"boxes": [BOX]}, story="# An arm", turn_s=300, recordings_keep_days=7, recordings_limit_mb=100,
    )  # fmt: skip
    irat = Robot.objects.create(
        slug="irat", name="Rat", driver="irat", address="sim:irat", enabled=True, cycle="ready", records=Records.WORK
    )
    Robot.objects.create(slug="spare", name="Spare", driver="mercury", address="sim:mercury")  # in no queue
    robots = (mercury, pa10, irat)
    for n, robot in enumerate(robots):
        Lease.objects.create(robot=robot, epoch=1, expires_at=now + timedelta(days=9), state={"values": DRIVEN})
        queue.queue_of(robot)
        load_bank(robot)
        Incident.objects.create(
            robot=robot, at=now, code="hardware_fault", text="It was silent.", remedy="Opened again."
        )
        Usage.objects.create(robot=robot, at=now - timedelta(hours=n), online_s=300, watching=3, sent_bytes=10**6)
    Robot.objects.filter(pk=mercury.pk).update(records=Records.WORK, settings={"speed": 0.1})
    asked = questions()
    done = job_done(irat, ada, now - timedelta(minutes=30))
    turn = driven(mercury, ada, now - timedelta(hours=2))
    frame = Frame.objects.filter(grant=turn.grant).first()
    log.write(turn, ada, "I found a watch.", frame.pk, now)
    log.answer_survey(turn, ada, dict(zip([q.pk for q in asked], ("4", "Yes", "=chess"), strict=True)), now)
    other = driven(mercury, bob, now - timedelta(hours=1))
    entry = log.write(other, bob, "Rude words.", None, now)
    log.moderate(entry, people["root"], log.Visibility.HIDDEN, "not kind", now)
    Clearance.objects.create(user=eve, robot=pa10, granted_at=now)
    driven(pa10, eve, now - timedelta(minutes=50))
    log.answer_survey_of_job(done, Asker(user=ada), {asked[0].pk: "5", asked[1].pk: "No"}, now)
    ask(irat, Asker(guest="a" * 64, network="192.0.2.1"), "goal", {"map": 1, "x": 1.0, "y": 1.0}, now)
    mark_read(eve, mercury, now)
    begin(eve, mercury, now)
    Attempt.objects.create(user=eve, robot=pa10, drawn=[], started_at=now, finished_at=now, score=1, passed=False)
    Clearance.objects.filter(user=bob, robot=mercury).update(revoked_at=now, note="It was pushed.")
    for author, shared in ((ada, True), (None, False)):
        Program.objects.create(
            robot=pa10,
            author=author,
            name=f"a square {shared}",
            text="home",
            shared=shared,
            approved=True,
            changed_at=now,
        )
    hidden = log.begin_first(mercury, now)
    turn = Turn.objects.filter(robot=mercury).first()
    spoon = Find(round=hidden, turn=turn, author=ada, name="a spoon", x=0.1, y=0.4, seen_at=now, reported_at=now)
    spoon.piece, spoon.state = hidden.pieces.first(), Find.State.CONFIRMED
    spoon.save()
    LostConnection.objects.create(turn=Turn.objects.filter(robot=mercury).first(), at=now, cause="cut")
    alert = Alert.objects.create(robot=pa10, kind="incident", subject="fault", text="It was silent.", seen_at=now)
    AlertMessage.objects.create(alert=alert, over=False, user=people["kim"], next_at=now)
    HidingReason.objects.get_or_create(text="It is a riddle.")  # those of the migration may have gone
    Movie.objects.create(robot=mercury, day=now.date(), kind="webm", state="failed", asked_at=now, reason="no picture")
    drive(mercury, ada, now)
    queue.join(pa10, eve, now)
    EmailAddress.objects.create(user=ada, email=ada.email, verified=True, primary=True)
    Group.objects.create(name="Moderators").permissions.set(Permission.objects.filter(codename="change_entry"))
    assert Turn.objects.filter(ended_at=None).count() == Ticket.objects.filter(state="operating").count() == 1
    return asked
