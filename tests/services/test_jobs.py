"""Jobs: asked for, promoted, settled; two guests and a driver in one fair queue."""

import pytest
from django.core.exceptions import ValidationError

from queueing import services as queue
from queueing import tasks
from queueing.errors import NotCleared, NotYourJob, RobotUnavailable, TooManyJobs
from queueing.models import Account, Job, QueueRobot, Ticket, TicketState
from queueing.services import Asker, ask, cancel, resume
from robots import services
from robots.kit.contract.errors import BadRequest, NotPermitted
from robots.models import Command, Grant, Robot
from robots.services.permissions import NotStaff
from robots.states import CommandState, Cycle, GrantEnd, GrantKind
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db]
GUEST, OTHER = Asker(guest="a" * 64, network="192.0.2.1"), Asker(guest="b" * 64, network="192.0.2.2")


def running():
    return Job.objects.filter(state="running").first()


def settle(clock, state=CommandState.COMPLETED, reason="", seconds=5, **result):
    """Let the owner end the command that runs, and the queue follow."""
    command = Command.objects.select_related("robot", "grant").filter(ended_at=None).get()
    rows.finish(command, state, clock.go(seconds), reason, result)
    queue.tick(clock.now())
    return command


def test_a_job_is_promoted_in_one_go_and_settles_with_its_command(shuttle, people, clock):
    job = ask(shuttle, Asker(user=people["eve"]), "go", {"x": 1.0}, clock.now(), name="Eve")
    assert (job.state, job.start_tag) == ("waiting", 0.0)
    queue.tick(clock.now())
    job.refresh_from_db()
    run = job.runs.get()
    command = run.grant.commands.get()
    assert (job.state, run.grant.kind, run.grant.holder, command.kind, command.args) == (
        "running",
        "job",
        None,
        "go",
        {"x": 1.0},
    )
    queue.tick(clock.go(1))
    assert Command.objects.count() == 1
    settle(clock)
    job.refresh_from_db()
    run.grant.refresh_from_db()
    assert (job.state, job.charged, run.grant.end_code) == ("done", 1.0, GrantEnd.FINISHED)
    assert Robot.objects.get().cycle == Cycle.READY, "no handover between jobs"


def test_two_who_always_ask_are_served_in_turn(shuttle, people, clock):
    ada, bob = Asker(user=people["ada"]), Asker(user=people["bob"])
    for _ in range(6):
        ask(shuttle, ada, "go", {"x": 1.0}, clock.now())
    served = []
    for _ in range(3):
        ask(shuttle, bob, "go", {"x": 2.0}, clock.now())
    queue.tick(clock.now())
    while running():
        served.append(running().user.username)
        settle(clock)
    assert served == ["ada", "bob", "ada", "bob", "ada", "bob", "ada", "ada", "ada"]
    assert Job.objects.filter(start_tag=None).count() == 0


@pytest.mark.asvs("2.4.1")
def test_guests_of_one_address_share_one_account_and_a_cookie_has_one_open_job(shuttle, people, clock):
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    with pytest.raises(TooManyJobs):
        ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    beside = ask(shuttle, Asker(guest="c" * 64, network=GUEST.network), "go", {"x": 1.0}, clock.now())
    elsewhere = ask(shuttle, OTHER, "go", {"x": 1.0}, clock.now())
    assert (beside.start_tag, elsewhere.start_tag) == (None, 0.0)
    assert Account.objects.filter(user=None).count() == 2
    queue.tick(clock.now())
    settle(clock)
    assert running() == elsewhere
    settle(clock)
    assert running() == beside


def test_a_heavier_weight_of_guests_waits_less(shuttle, people, clock):
    shuttle.queue_link.queue.__class__.objects.update(guest_weight=4.0)
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    settle(clock)
    account = Account.objects.get(user=None)
    assert account.finish_tag == pytest.approx(0.25)
    Account.objects.update(weight=8.0)  # of a school, by staff
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    settle(clock)
    account.refresh_from_db()
    assert (account.finish_tag, account.weight) == (pytest.approx(0.25 + 0.125), 8.0)
    for wrong in (0.0, -1.0, float("nan")):
        account.weight = wrong
        with pytest.raises(ValidationError):
            account.full_clean()


def test_who_may_ask(shuttle, people, clock):
    QueueRobot.objects.update(guests_ask=False)
    for asker in (GUEST, Asker(user=people["eve"])):
        with pytest.raises(NotCleared):
            ask(shuttle, asker, "go", {"x": 1.0}, clock.now())
    ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    for kind, args in (
        ("dock", {}),
        ("go", {}),
        ("go", {"x": float("nan")}),
        ("go", {"x": 1e308}),
        ("jump", {}),
        ("go", []),
    ):
        with pytest.raises(BadRequest):
            ask(shuttle, Asker(user=people["ada"]), kind, args, clock.now())
    Robot.objects.update(enabled=False)
    with pytest.raises(RobotUnavailable):
        ask(Robot.objects.get(), Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())


def test_ten_open_jobs_and_no_more(shuttle, people, clock):
    for _ in range(10):
        ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    with pytest.raises(TooManyJobs):
        ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    assert Job.objects.filter(start_tag__isnull=False).count() == 1


def many(shuttle, clock, number):
    """Give each of so many network addresses an open job."""
    queue_ = shuttle.queue_link.queue
    accounts = Account.objects.bulk_create(Account(queue=queue_, network=f"2001:db8::{n}") for n in range(number))
    Job.objects.bulk_create(
        Job(queue=queue_, robot=shuttle, account=a, guest=f"{n:064}", kind="go", args={"x": 1.0}, asked_at=clock.now())
        for n, a in enumerate(accounts)
    )


@pytest.mark.asvs("2.4.1")
def test_a_robot_takes_so_many_jobs_and_leaves_some_places_to_people_with_an_account(shuttle, people, clock):
    many(shuttle, clock, 199)
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    with pytest.raises(TooManyJobs, match="as many jobs as it can take"):
        ask(shuttle, OTHER, "go", {"x": 1.0}, clock.now())
    ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    Job.objects.filter(user=None).update(state="done")
    ask(shuttle, OTHER, "go", {"x": 1.0}, clock.now())


def test_people_too_are_refused_at_the_last_place(shuttle, people, clock):
    many(shuttle, clock, 299)
    ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    with pytest.raises(TooManyJobs, match="as many jobs as it can take"):
        ask(shuttle, Asker(user=people["kim"]), "go", {"x": 1.0}, clock.now())


def test_jobs_of_guests_are_forgotten_after_400_days_and_those_of_people_are_kept(shuttle, people, clock):
    old, _, mine = (ask(shuttle, a, "go", {"x": 1.0}, clock.now()) for a in (GUEST, OTHER, Asker(user=people["ada"])))
    for job in (old, mine):
        Job.objects.filter(pk=job.pk).update(state="done", ended_at=clock.now())
    clock.go(400 * 86_400)
    assert tasks.forget_old_jobs(clock.now()) == 0, "not one day early"
    assert tasks.forget_old_jobs(clock.go(1)) == 1
    assert set(Job.objects.values_list("guest", flat=True)) == {OTHER.guest, ""}, "what is open stays"
    assert set(Account.objects.values_list("network", flat=True)) == {OTHER.network, ""}
    Job.objects.filter(guest=OTHER.guest).update(state="done", ended_at=clock.now())
    assert tasks.forget_old_jobs(clock.now()) == 0
    assert Account.objects.count() == 2, "an account with a job stays"


def test_old_jobs_are_forgotten_every_hour(shuttle, clock, trusted, settings, monkeypatch):
    monkeypatch.setattr(tasks, "wall_clock", lambda: trusted)
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    Job.objects.update(state="done", ended_at=clock.now())
    clock.go(401 * 86_400)
    planned = next(entry for entry in settings.CELERY_BEAT_SCHEDULE.values() if entry["task"] == "queueing.clean")
    assert (planned["schedule"], tasks.clean.name) == (3600.0, planned["task"])
    assert tasks.clean() == 1
    assert not Job.objects.filter(pk=job.pk).exists()


@pytest.mark.parametrize("state", ["failed", "expired"])
def test_what_a_fault_cut_short_waits_again_with_its_tag_and_costs_nothing(shuttle, people, clock, state):
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    settle(clock, state, "The motor is hot.")
    job.refresh_from_db()
    assert (job.state, job.start_tag, job.runs.count()) == ("running", 0.0, 2), "a new grant, the same place"
    settle(clock)
    job.refresh_from_db()
    assert (job.state, job.charged) == ("done", 1.0)


@pytest.mark.parametrize(("state", "code", "cost"), [("failed", "gave_up", 1.0), ("rejected", "bad_request", 0.0)])
def test_what_the_robot_gives_up_or_refuses_is_not_asked_of_it_again(shuttle, people, clock, state, code, cost):
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    settle(clock, state, "A leaf lies on the rail.", code=code)
    job.refresh_from_db()
    assert (job.state, job.reason, job.charged) == ("failed", "A leaf lies on the rail.", cost)
    assert job.runs.count() == 1


def test_a_robot_that_fails_again_and_again_ends_the_job(shuttle, people, clock):
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    for _ in range(3):
        settle(clock, CommandState.FAILED, "The motor is hot.")
    job.refresh_from_db()
    assert (job.state, job.charged, "motor is hot" in job.reason) == ("failed", 0.0, True)


def test_unknown_is_final(shuttle, people, clock):
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    settle(clock, CommandState.UNKNOWN, "Interrupted.")
    job.refresh_from_db()
    assert (job.state, job.charged) == ("unknown", 0.0)
    queue.tick(clock.go(60))
    assert Command.objects.filter(kind="go").count() == 1


def test_a_stop_ends_the_running_job_and_suspends_the_rest_until_staff_resume(shuttle, people, clock):
    first, second = (ask(shuttle, asker, "go", {"x": 1.0}, clock.now()) for asker in (GUEST, OTHER))
    queue.tick(clock.go(1))
    services.stop(shuttle, people["kim"], clock.go(1))
    queue.tick(clock.go(1))
    first.refresh_from_db()
    assert (first.state, first.reason) == ("cancelled", "The robot was stopped.")
    with pytest.raises(NotPermitted):
        resume(shuttle, people["kim"], clock.now())
    services.release_stop(shuttle, people["kim"], True)
    queue.tick(clock.go(5))
    second.refresh_from_db()
    assert (second.state, second.start_tag) == ("waiting", 0.0), "a release starts nothing"
    with pytest.raises(NotStaff):
        resume(shuttle, people["ada"], clock.now())
    resume(shuttle, people["kim"], clock.now())
    queue.tick(clock.now())
    assert running() == second


def test_who_asked_may_cancel_and_nobody_else(shuttle, people, clock):
    first, second = (ask(shuttle, asker, "go", {"x": 1.0}, clock.now()) for asker in (GUEST, OTHER))
    for stranger in (OTHER, Asker(user=people["ada"]), Asker()):
        with pytest.raises(NotYourJob):
            cancel(first, stranger, clock.now())
    queue.tick(clock.now())
    cancel(first, GUEST, clock.go(2))
    cancel(second, Asker(user=people["kim"]), clock.now())
    queue.tick(clock.now())
    assert {Job.objects.get(pk=j.pk).state for j in (first, second)} == {"cancelled"}
    assert not Robot.objects.get().stop_latched
    assert Grant.objects.get(kind=GrantKind.JOB).end_code == GrantEnd.HOLDER


def test_a_turn_at_the_head_is_offered_after_a_handover_and_no_job_starts_until_the_offer_ends(shuttle, people, clock):
    QueueRobot.objects.update(offers_turns=True)
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    ticket = queue.join(shuttle, people["ada"], clock.go(1))
    late = ask(shuttle, OTHER, "go", {"x": 1.0}, clock.go(1))
    settle(clock)
    assert Robot.objects.get().cycle == Cycle.HANDOVER, "in order first"
    grant = services.start_grant(shuttle, GrantKind.HANDOVER, clock.now())
    services.end_grant(grant, GrantEnd.FINISHED, "in order", clock.now())
    Robot.objects.update(cycle=Cycle.READY)
    queue.tick(clock.now())
    ticket.refresh_from_db()
    assert ticket.state == TicketState.OFFERED
    queue.tick(clock.go(5))
    assert running() is None
    queue.tick(clock.go(60))
    assert Ticket.objects.get().state == TicketState.EXPIRED
    assert running() == late


def test_a_ticket_of_ones_own_takes_the_place_of_ones_waiting_job(shuttle, people, clock):
    QueueRobot.objects.update(offers_turns=True)
    Robot.objects.update(cycle=Cycle.FAULT)
    job = ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    queue.join(shuttle, people["ada"], clock.go(1))
    job.refresh_from_db()
    assert job.start_tag is None
    queue.leave(shuttle, people["ada"], clock.go(1))
    queue.tick(clock.now())
    job.refresh_from_db()
    assert job.start_tag == 0.0


def test_nobody_joins_where_no_turns_are_offered(shuttle, people, clock):
    with pytest.raises(RobotUnavailable):
        queue.join(shuttle, people["ada"], clock.now())


def test_the_snapshot_says_what_this_person_can_do_now(shuttle, people, clock):
    from django.contrib.auth.models import AnonymousUser

    from portal.live.snapshot import snapshot

    def can(user):
        return {what for what, may in snapshot(shuttle.slug, user, clock.now(), True)["me"]["can"].items() if may}

    assert can(AnonymousUser()) == {"watch", "ask"}
    assert can(people["kim"]) == {"watch", "ask", "stop"}
    QueueRobot.objects.update(guests_ask=False)
    assert can(AnonymousUser()) == can(people["eve"]) == {"watch"}
    assert can(people["ada"]) == {"watch", "ask"}
    ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    assert can(people["ada"]) == {"watch", "ask"}, "who asked drives nothing and stops nothing"
    Robot.objects.update(enabled=False)
    assert can(people["ada"]) == {"watch"}
