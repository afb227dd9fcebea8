"""Promise 21: Redis and every process may be killed; nothing that was confirmed is lost."""

import random

import pytest

from operatorlog import services as log
from operatorlog.models import Entry, SurveyAnswer, SurveyQuestion, SurveyResponse
from queueing import services as queue
from queueing.models import Ticket, Turn
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.models import Command, Grant
from robots.states import COMMAND_FINAL
from tests.conftest import wait_for
from tests.rig import Web, housekeeping


def works(rig, seconds):
    """Wait until a command is carried out again by itself."""

    def done():
        try:
            return rig.final(rig.issue("noop"), 2).state == "completed"
        except (NotPermitted, AssertionError):
            return False

    wait_for(done, seconds, "work goes on by itself")


@pytest.mark.asvs("2.3.3")
def test_promise_21_nothing_acknowledged_is_lost(rig, proof):
    """FLUSHALL and kills of everything, Redis too, at random moments, under commands, log entries and surveys."""
    dice = random.Random(21)
    times = proof.count("kills and flushes", 2, 15, 100)
    told, entries, surveys, places = set(), set(), set(), set()
    question = SurveyQuestion.objects.create(prompt="How was it?", kind=SurveyQuestion.Kind.TEXT)
    site = Web()
    rig.owner()
    rig.grant(seconds=3000)
    housekeeper = housekeeping()
    try:
        for i in range(times):
            for _ in range(dice.randint(1, 4)):
                try:
                    told.add(rig.issue("noop").pk)
                except NotPermitted:
                    SYSTEM.sleep(0.5)
            entry, survey = write_down(rig, f"entry {i}", question)
            entries.add(entry)
            surveys.add(survey)
            places.add(queue.join(rig.robot, rig.people["bob"], rig.now()).pk)
            if i % 2:
                queue.leave(rig.robot, rig.people["bob"], rig.now())
            if i % 2:
                rig.redis.stop()
            else:
                bus.connection().flushall()
            victims = [site, housekeeper, *[w for w in rig.workers if w.alive()]]
            for victim in dice.sample(victims, dice.randint(1, len(victims))):
                victim.kill()
            if i % 2:
                rig.redis.start()
            if not site.alive():
                site = Web()
            if not housekeeper.alive():
                housekeeper = housekeeping()
            if not any(w.alive() for w in rig.workers):
                rig.start_worker()
            works(rig, 40)
        wait_for(lambda: not Command.objects.exclude(state__in=COMMAND_FINAL).exists(), 40, "every end")
    finally:
        housekeeper.kill()
        site.kill()
    assert set(Command.objects.values_list("pk", flat=True)) >= told
    assert set(Entry.objects.values_list("pk", flat=True)) == entries
    assert set(SurveyResponse.objects.values_list("pk", flat=True)) == surveys
    answers = SurveyAnswer.objects.filter(response__in=surveys).values_list("value", flat=True)
    assert sorted(answers) == sorted(f"entry {i}" for i in range(times))
    assert set(Ticket.objects.values_list("pk", flat=True)) >= places
    proof.holds(
        f"{times} times: {len(told)} commands, {len(entries)} log entries, {len(surveys)} surveys, {len(places)} queue "
        "places told, 0 lost"
    )


def write_down(rig, text, question):
    """Write a log entry and a survey about a turn of eve's that is over; return what she was told."""
    now, eve = rig.now(), rig.people["eve"]
    grant = Grant.objects.create(robot=rig.robot, kind="turn", holder=eve, opened_at=now, ended_at=now, end_reason="x")
    ticket = Ticket.objects.create(
        queue=queue.queue_of(rig.robot), user=eve, state="done", start_tag=0, joined_at=now, last_seen=now
    )
    turn = Turn.objects.create(
        robot=rig.robot, user=eve, ticket=ticket, grant=grant, started_at=now, base_until=now, until=now,
        last_seen=now, ended_at=now, end_reason="x",
    )  # fmt: skip
    entry, survey, _ = log.hand_in(turn, eve, text, None, {question.pk: text}, now)
    return entry.pk, survey.pk
