"""A program that ran in a turn: its movie is made automatically, and the turn's page shows movie and path."""

import pytest
from django.test import Client

from operatorlog.models import Entry, Visibility
from queueing.models import Job, Turn
from robots.kit.clock import SYSTEM
from robots.models import Command, Movie
from robots.recordings import movies
from robots.recordings.findings import SHOWN
from robots.states import GrantKind
from tests.services.tapes import let_make
from tests.services.test_job_movies import ran

pytestmark = [
    pytest.mark.django_db, pytest.mark.usefixtures("media"), pytest.mark.parametrize("which", ["srv1"], indirect=True)
]  # fmt: skip


def driven(robot, people, kind="mission", args=None):
    """Return a turn of ada's that is over, in which she gave this command, and its recording."""
    _, recording = ran(robot, people, kind=kind, args=args)
    grant = recording.grant
    Job.objects.all().delete()
    grant.kind, grant.holder = GrantKind.TURN, people["ada"]
    grant.save()
    began, ended = recording.began_at, recording.ended_at
    turn = Turn.objects.create(
        robot=robot, user=people["ada"], grant=grant, started_at=began, base_until=ended, until=ended, last_seen=ended,
        ended_at=ended,
    )  # fmt: skip
    return turn, recording


def page(turn, user=None):
    client = Client()
    if user is not None:
        client.force_login(user)
    return client.get(turn.get_absolute_url()).content.decode()


def test_a_movie_of_a_mission_in_a_turn_comes_by_itself_and_the_page_shows_path_and_movie(robot, people):
    turn, recording = driven(robot, people)
    said = page(turn)
    assert "A movie of it will be made." in said and said.count("data-arrives") == 2
    assert movies.ask_due(SYSTEM.now()) == 1 and movies.ask_due(SYSTEM.now()) == 0
    let_make(Movie.objects.get())
    said = page(turn)
    assert f'href="{recording.get_absolute_url()}movie.mp4"' in said and "data-arrives" not in said
    assert said.count("<polyline") == 2 and "It drove 5.2 m, from (1.0, 1.0) to (6.0, 2.3)." in said
    assert said.index("Where it drove") < said.index("What it found"), "its numbers are explained by the table below it"
    assert "nobody else reads this" not in said


def test_without_a_movie_the_page_joins_the_places_that_were_noted(robot, people):
    turn, recording = driven(robot, people)
    finding = Command.objects.get().findings.first()
    finding.pk, finding.number, finding.pose = None, 3, [2.0, 1.0, 0.0]
    finding.save()
    recording.delete()
    assert page(turn).count("<polyline") == 1


def test_the_path_goes_through_the_places_that_the_table_leaves_out(robot, people):
    turn, recording = driven(robot, people)
    finding = Command.objects.get().findings.first()
    for number in range(3, SHOWN + 4):
        finding.pk, finding.number, finding.pose = None, number, [2.0 + number / 50, 1.0, 0.0]
        finding.save()
    recording.delete()
    assert f"to ({2.0 + (SHOWN + 3) / 50:.1f}, 1.0)." in page(turn)


@pytest.mark.parametrize(("kind", "args"), [("go", {"x": 6.0, "y": 2.3}), ("turn", {"angle": 1.0})])
def test_of_a_turn_without_a_program_no_movie_is_made(robot, people, kind, args):
    turn, _ = driven(robot, people, "go", {"x": 6.0, "y": 2.3})
    Command.objects.update(kind=kind, args=args)
    assert movies.ask_due(SYSTEM.now()) == 0
    assert "A movie of it" not in page(turn)


def test_what_a_hidden_entry_hides_is_in_no_movie_and_no_path(robot, people):
    turn, _ = driven(robot, people)
    movies.ask_due(SYSTEM.now())
    let_make(Movie.objects.get())
    Entry.objects.create(
        robot=robot, turn=turn, author=people["ada"], text="rude", visibility=Visibility.HIDDEN, written_at=SYSTEM.now()
    )
    others, own = page(turn), page(turn, people["ada"])
    assert "movie.mp4" not in others and "It drove 5.2 m" not in others
    assert "movie.mp4" in own and "It drove 5.2 m" in own
