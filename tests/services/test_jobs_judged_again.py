"""A waiting job is judged again by the rule for its request; a job that is no longer allowed ends with a reason."""

from dataclasses import replace

import pytest
from django.core import mail
from django.db import connection
from django.test.utils import CaptureQueriesContext

from accounts.models import Clearance
from queueing import services as queue
from queueing.jobs.judging import head_of
from queueing.jobs.kinds import may_ask
from queueing.models import Job, QueueRobot
from queueing.services import Asker, ask
from queueing.tick import busy_queues
from robots.kit.contract.find import spec_of
from robots.kit.contract.spec import STAFF
from robots.models import Robot
from robots.states import Cycle
from tests.services.test_jobs import GUEST

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def waits(shuttle, people, clock):
    """Jobs of a guest and of Ada on a robot that is in no state to begin one."""
    Robot.objects.update(cycle=Cycle.FAULT)
    return [ask(shuttle, asker, "go", {"x": 1.0}, clock.now()) for asker in (GUEST, Asker(user=people["ada"]))]


def told(jobs):
    for job in jobs:
        job.refresh_from_db()
    return [(job.state, job.reason) for job in jobs]


def of_staff_alone(monkeypatch):
    """Let the shuttle's spec give `go` to staff alone, as a newer version of its package might."""
    spec = spec_of("shuttle")
    closed = tuple(replace(kind, asked_by=frozenset({STAFF})) for kind in spec.commands)
    monkeypatch.setattr("robots.kit.contract.find.spec_of", lambda name: replace(spec, commands=closed))


WAITS = ("waiting", "")
NO_GUESTS = ("cancelled", "This robot no longer takes jobs from guests.")
NOT_CLEARED = ("cancelled", "The person who asked for it is no longer cleared for this robot.")
SWITCHED_OFF = ("cancelled", "The account of the person who asked for it is switched off.")
NO_SUCH_KIND = ("cancelled", "This robot no longer takes this kind of job.")


@pytest.mark.parametrize(
    ("happens", "guest", "ada"),
    [
        (lambda ada, patch: None, WAITS, WAITS),
        (lambda ada, patch: Clearance.objects.all().delete(), WAITS, WAITS),
        (lambda ada, patch: type(ada).objects.filter(pk=ada.pk).update(is_active=False), WAITS, SWITCHED_OFF),
        (lambda ada, patch: QueueRobot.objects.update(guests_ask=False), NO_GUESTS, WAITS),
        (lambda ada, patch: of_staff_alone(patch), NO_SUCH_KIND, NO_SUCH_KIND),
    ],
    ids=["nothing", "guests may ask, so everybody may", "account switched off", "no guests", "kind of staff"],
)
def test_who_may_no_longer_ask_does_not_wait_either(shuttle, people, clock, waits, monkeypatch, happens, guest, ada):
    happens(people["ada"], monkeypatch)
    queue.tick(clock.go(1))
    assert told(waits) == [guest, ada]


@pytest.mark.parametrize("loss", [{"level": 0}, {"revoked_at": "now"}, None])
def test_a_clearance_that_was_withdrawn_ends_its_persons_waiting_job(shuttle, people, clock, waits, loss):
    QueueRobot.objects.update(guests_ask=False)
    mine = Clearance.objects.filter(user=people["ada"])
    if loss is None:
        mine.delete()
    else:
        mine.update(**{name: clock.now() if value == "now" else value for name, value in loss.items()})
    queue.tick(clock.go(1))
    assert told(waits)[1] == NOT_CLEARED
    Robot.objects.update(clearance_required=False)
    again = ask(Robot.objects.get(), Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    queue.tick(clock.go(1))
    assert told([again]) == [WAITS], "nobody needs a clearance now"


def test_the_rule_in_the_database_is_the_rule_of_asking(shuttle, people, clock, waits):
    """Every combination of what it depends on: guests let in, clearance wanted, level, account."""
    job, kind = waits[1], spec_of("shuttle").command("go")
    Job.objects.filter(pk=waits[0].pk).update(state="done")
    for number in range(16):
        guests, wanted, level, active = (bool(number & bit) for bit in (1, 2, 4, 8))
        QueueRobot.objects.update(guests_ask=guests)
        Robot.objects.update(clearance_required=wanted, cycle=Cycle.READY)
        Clearance.objects.update(level=int(level))
        type(people["ada"]).objects.update(is_active=active)
        people["ada"].refresh_from_db()
        robot = Robot.objects.get()
        assert (head_of(robot, QueueRobot.objects.get()) == job) is may_ask(robot, people["ada"], kind, guests), number


def test_no_job_starts_whose_asker_may_no_longer_ask_though_nothing_ticked_meanwhile(shuttle, people, clock, waits):
    QueueRobot.objects.update(guests_ask=False)
    type(people["ada"]).objects.filter(pk=people["ada"].pk).update(is_active=False)
    assert head_of(Robot.objects.get(), QueueRobot.objects.get()) is None


def test_a_dropped_job_keeps_neither_the_queue_busy_nor_the_robot_awake(shuttle, people, clock, waits):
    type(people["ada"]).objects.filter(pk=people["ada"].pk).update(is_active=False)
    QueueRobot.objects.update(guests_ask=False)
    Robot.objects.update(cycle=Cycle.READY)
    before = QueueRobot.objects.get().watched_at
    queue.tick(clock.go(1))
    assert not busy_queues().exists()
    assert QueueRobot.objects.get().watched_at == before, "it was no watcher"


def test_jobs_of_a_package_that_is_not_there_now_wait_for_it(shuttle, people, clock, waits, monkeypatch):
    def gone(name):
        raise LookupError(name)

    monkeypatch.setattr("robots.kit.contract.find.spec_of", gone)
    Robot.objects.update(cycle=Cycle.READY)
    queue.tick(clock.go(1))
    assert told(waits) == [WAITS, WAITS]


def test_a_mail_about_it_goes_to_nobody_whose_account_is_off(
    shuttle, people, clock, django_capture_on_commit_callbacks
):
    Robot.objects.update(cycle=Cycle.FAULT)
    ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now(), mail=True)
    ask(shuttle, Asker(user=people["bob"]), "go", {"x": 1.0}, clock.now(), mail=True)
    type(people["ada"]).objects.filter(pk=people["ada"].pk).update(is_active=False)
    QueueRobot.objects.update(guests_ask=False)
    Clearance.objects.filter(user=people["bob"]).delete()
    with django_capture_on_commit_callbacks(execute=True):
        queue.tick(clock.go(1))
    assert [message.to for message in mail.outbox] == [[people["bob"].email]]
    assert NOT_CLEARED[1] in mail.outbox[0].body


def test_waiting_jobs_cost_a_tick_the_same_however_many_they_are(shuttle, people, clock):
    Robot.objects.update(cycle=Cycle.FAULT)
    QueueRobot.objects.update(guests_ask=False)
    counts = []
    for name in ("ada", "bob", "kim"):
        Clearance.objects.get_or_create(user=people[name], robot=shuttle, defaults={"granted_at": clock.now()})
        ask(shuttle, Asker(user=people[name]), "go", {"x": 1.0}, clock.now())
        queue.tick(clock.go(30))
        with CaptureQueriesContext(connection) as queries:
            queue.tick(clock.go(1))
        counts.append(len(queries))
    assert counts == [counts[0]] * 3
    assert Job.objects.filter(state="waiting").count() == 3
