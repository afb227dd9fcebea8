"""The movie of the day: which one the rule chooses, how staff choose, what removes it, and what its page shows."""

from datetime import timedelta

import pytest
from django.test import Client

from operatorlog.models import Entry, Visibility
from portal.web.recordings.day import may_be_shown, movie_of_the_day
from queueing.models import Job, JobRun, Turn
from robots import services
from robots.grants import end_grant, start_grant
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest
from robots.models import Frame, Movie, Recording, RecordingState
from robots.models.recordings import OfTheDay
from robots.recordings import cleaning, keeping
from robots.states import GrantEnd, GrantKind
from tests.services.browsers import signed_in
from tests.services.test_job_movies import GREY, ran, taped

pytestmark = [
    pytest.mark.django_db, pytest.mark.usefixtures("media"), pytest.mark.parametrize("which", ["srv1"], indirect=True)
]  # fmt: skip
PAGE = "/movie-of-the-day/"
DAY = timedelta(days=1)


def filmed(recording, kind="mp4", ready_at=None):
    """Return a movie of a recording that was ready yesterday, or then."""
    ready_at = ready_at or SYSTEM.now() - DAY
    movie = Movie.objects.create(
        robot=recording.robot, recording=recording, kind=kind, version=recording.version, state=Movie.State.READY,
        asked_at=ready_at, ready_at=ready_at, size=7,
    )  # fmt: skip
    keeping.movie_path(movie).parent.mkdir(exist_ok=True)
    keeping.movie_path(movie).write_bytes(b"a movie")
    return movie


def of_turn(robot, person):
    """Return the recording of a turn that has ended, as long as those of `ran`."""
    now = SYSTEM.now()
    grant = start_grant(robot, GrantKind.TURN, now - timedelta(seconds=20), person, now + DAY)
    turn = Turn.objects.create(
        robot=robot, user=person, grant=grant, started_at=now, base_until=now, until=now, last_seen=now, ended_at=now
    )
    recording = taped(keeping.begin(grant, "here", now - timedelta(seconds=20)), GREY)
    end_grant(grant, GrantEnd.FINISHED, "", now)
    keeping.finish(recording, RecordingState.READY, "", now)
    return turn, recording


def chosen(now=None):
    found = movie_of_the_day(now or SYSTEM.now())
    return found and found.movie


def page(user=None):
    return signed_in(user).get(PAGE).content.decode()


@pytest.fixture
def two(robot, people):
    """The movies of two missions, both ready yesterday; the older one first."""
    recordings = [ran(robot, people)[1] for _ in range(2)]
    return [filmed(recording) for recording in recordings]


def test_the_newest_movie_that_was_ready_when_the_day_began_is_shown_all_day(robot, people, two):
    now = SYSTEM.now()
    assert chosen() == two[1]
    of_today = filmed(ran(robot, people)[1], ready_at=now)
    morning, night = now.replace(hour=0, minute=0, second=1), now.replace(hour=23, minute=59, second=59)
    assert chosen(morning) == chosen(night) == two[1]
    assert chosen(night + timedelta(seconds=1)) == of_today


def test_its_page_shows_it_to_everybody(two):
    recording = two[1].recording
    said = page()
    address = f"{recording.get_absolute_url()}movie.mp4"
    assert f'src="{address}"' in said and "by ada" not in said and "No movie was made of" not in said
    assert Job.objects.get(runs__grant=recording.grant).get_absolute_url() in said
    assert Client().get(address).status_code == 200


def test_without_one_the_page_says_so(robot):
    assert "There is no movie of the day yet." in page() and "<video" not in page()


def test_after_a_day_without_a_movie_the_last_one_is_shown_with_its_date(two):
    began = SYSTEM.now() - 5 * DAY
    Recording.objects.update(began_at=began, ended_at=began + timedelta(seconds=20))
    said = page()
    assert f"This is the last one, of {began:%-d %B %Y}." in said and "<video" in said


def hidden(recording, people):
    job = Job.objects.get(runs__grant=recording.grant)
    JobRun.objects.filter(job=job).delete()
    job.delete()
    now = SYSTEM.now()
    turn = Turn.objects.create(
        robot=recording.robot, user=people["ada"], grant=recording.grant, started_at=now, base_until=now, until=now,
        last_seen=now, ended_at=now,
    )  # fmt: skip
    assert chosen().recording == recording
    Entry.objects.create(
        turn=turn, author=people["ada"], robot=recording.robot, text="x", written_at=now, visibility=Visibility.HIDDEN
    )


def job_deleted(recording, people):
    Job.objects.filter(runs__grant=recording.grant).delete()


def of_a_guest(recording, people):
    Job.objects.filter(runs__grant=recording.grant).update(user=None)


def removed(recording, people):
    services.remove_recording(recording, people["kim"])


def picture_taken_down(recording, people):
    at = recording.began_at + timedelta(seconds=3)
    frame = Frame.objects.create(robot=recording.robot, grant=recording.grant, taken_at=at, file="frames/y.jpg")
    services.take_down(frame, people["kim"])


def never(recording, people):
    services.choose_of_the_day(recording, OfTheDay.NEVER, people["kim"])


@pytest.mark.parametrize("pinned", [False, True])
@pytest.mark.parametrize("how", [hidden, job_deleted, of_a_guest, removed, picture_taken_down, never])
def test_what_not_everybody_may_see_any_more_is_not_shown(robot, people, two, how, pinned):
    kept = [Recording.objects.get(pk=movie.recording_id) for movie in two]
    if how is picture_taken_down:  # apart in time, for what was filmed within two seconds of a picture goes with it
        Recording.objects.filter(pk=kept[0].pk).update(began_at=SYSTEM.now() - DAY, ended_at=SYSTEM.now() - DAY / 2)
    if pinned:
        services.choose_of_the_day(kept[1], OfTheDay.PINNED, people["kim"])
    key = two[1].pk
    assert chosen() == two[1] and may_be_shown(key)
    how(kept[1], people)
    assert chosen() == two[0] and not may_be_shown(key)
    assert kept[1].key not in page(people["kim"])


def cut_short(movie):
    Recording.objects.filter(pk=movie.recording_id).update(state=RecordingState.CUT)


def short(movie):
    Recording.objects.filter(pk=movie.recording_id).update(ended_at=movie.recording.began_at + timedelta(seconds=9))


def as_webm(movie):
    Movie.objects.filter(pk=movie.pk).update(kind="webm")


def not_made(movie):
    Movie.objects.filter(pk=movie.pk).update(state=Movie.State.FAILED)


@pytest.mark.parametrize("how", [cut_short, short, as_webm, not_made])
def test_the_rule_leaves_out(two, how):
    how(two[1])
    assert chosen() == two[0]


def test_time_lapses_are_left_out(robot, two):
    Movie.objects.create(robot=robot, day=SYSTEM.now().date() - DAY, kind="mp4", state=Movie.State.READY, asked_at=SYSTEM.now(), ready_at=SYSTEM.now() - DAY)  # fmt: skip
    assert chosen() == two[1]


def test_turns_are_shown_as_well(robot, people, two):
    turn, recording = of_turn(robot, people["ada"])
    movie = filmed(recording)
    assert chosen() == movie and turn.get_absolute_url() in page()


def test_staff_pin_one_at_a_time_and_give_it_back_to_the_rule(robot, people, two):
    of_today = ran(robot, people)[1]
    assert services.choose_of_the_day(two[0].recording, OfTheDay.PINNED, people["kim"])
    assert chosen() == two[0]
    assert services.choose_of_the_day(of_today, OfTheDay.PINNED, people["kim"])
    assert Recording.objects.get(of_the_day=OfTheDay.PINNED) == of_today
    asked = Movie.objects.get(recording=of_today)
    assert asked.state == Movie.State.WAITING and chosen() == two[1], "until it is made"
    Movie.objects.filter(pk=asked.pk).update(state=Movie.State.READY, ready_at=SYSTEM.now())
    assert chosen() == asked, "at once"
    assert not services.choose_of_the_day(of_today, OfTheDay.PINNED, people["kim"])
    assert services.choose_of_the_day(of_today, OfTheDay.BY_RULE, people["kim"])
    assert chosen() == two[1]


def test_what_was_removed_cannot_be_pinned(two, people):
    keeping.remove(two[1].recording, "Staff removed it.")
    with pytest.raises(BadRequest):
        services.choose_of_the_day(two[1].recording, OfTheDay.PINNED, people["kim"])
    assert not Recording.objects.filter(of_the_day=OfTheDay.PINNED).exists()


def test_staff_choose_in_the_admin_and_nobody_else(robot, people, two, client, admin_client):
    old, new = (movie.recording for movie in two)

    def act(verb, *recordings, by=admin_client):
        data = {"action": verb, "_selected_action": [str(one.pk) for one in recordings]}
        return by.post("/admin/robots/recording/", data, follow=True).content.decode()

    client.force_login(people["mod"])
    act("pin", old, by=client)
    assert chosen() == two[1]
    assert "Movie of the day: until staff say otherwise: 1 recording." in act("pin", old)
    assert chosen() == two[0]
    assert "Choose one recording" in act("pin", old, new)
    act("never", old, new)
    assert chosen() is None
    act("by_rule", old, new)
    assert chosen() == two[1]


def test_it_stays_however_old_and_large_movies_may_be(settings, two):
    settings.RECORDING = settings.RECORDING | {"MOVIES_MB": 0}
    Movie.objects.update(asked_at=SYSTEM.now() - 9 * DAY)
    cleaning.clean(SYSTEM.now())
    assert list(Movie.objects.all()) == [two[1]] and keeping.movie_path(two[1]).exists()
    keeping.remove(two[1].recording, "Staff removed it.")
    assert chosen() is None and not keeping.movie_path(two[1]).exists()
