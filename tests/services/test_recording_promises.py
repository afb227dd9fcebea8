"""What docs/reference/recordings.md and settings.md promise about keeping and removing; each test quotes its sentence."""

from datetime import timedelta

import pytest
from django.test import Client

from queueing.models import Turn
from robots.kit.clock import SYSTEM, ms_of
from robots.kit.recording.container import COMMANDS
from robots.kit.recording.reading import messages
from robots.models import Recording
from robots.recordings import cleaning, keeping
from tests.services.admin_forms import as_sent, controls_of
from tests.services.tapes import tape_of
from tests.services.test_recordings import addresses, made, statuses

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("media")]
DAY = timedelta(days=1)


def removed_page(recording):
    page = Client().get(recording.get_absolute_url())
    assert page.status_code == 200
    return page.content.decode()


def set_in_admin(client, robot, **values):
    page = f"/admin/robots/robot/{robot.pk}/change/"
    assert client.post(page, as_sent(controls_of(client.get(page)), **values)).status_code == 302


def today():
    return f"{SYSTEM.now():%-d %B %Y}"


def test_the_page_of_a_recording_that_staff_removed_says_when_and_why(roles, admin_client):
    """The page of a removed recording says when and why. [...] They remove a whole recording under Recordings."""
    recording = made(Turn.objects.get().grant)
    chosen = {"action": "remove", "_selected_action": [recording.pk]}
    answer = admin_client.post("/admin/robots/recording/", chosen, follow=True)
    assert "Removed: 1 recording." in answer.content.decode()
    assert f"The recording was removed. {today()}: Staff removed it." in removed_page(recording)
    again = admin_client.post("/admin/robots/recording/", chosen, follow=True)
    assert "Removed before: 1 recording." in again.content.decode()


@pytest.mark.parametrize(("own", "days"), [("", 30), ("12", 12), ("0", 1)])
def test_a_recording_is_kept_for_the_days_that_staff_or_the_settings_say(roles, robot, admin_client, own, days):
    """`FARHAND_RECORDING_KEEP_DAYS`, or the robot's own number of days; the page says when and why."""
    set_in_admin(admin_client, robot, recordings_keep_days=own)
    recording = made(Turn.objects.get().grant)
    recording.robot.refresh_from_db()
    assert f"{recording.kept_until:%-d %B %Y}" in removed_page(recording)
    assert cleaning.clean(recording.began_at + days * DAY - timedelta(minutes=1)) == 0
    assert cleaning.clean(recording.began_at + days * DAY) == 1
    assert f"{today()}: Recordings are kept for {days} days." in removed_page(recording)


def test_the_oldest_go_first_where_staff_set_a_limit(roles, robot, admin_client):
    """of one robot at most `FARHAND_RECORDINGS_MB`, or its own limit: the oldest are removed first."""
    recording = made(Turn.objects.get().grant)
    Recording.objects.update(size=2_000_000)
    set_in_admin(admin_client, robot, recordings_limit_mb="1")
    assert cleaning.clean(SYSTEM.now()) == 1
    assert f"{today()}: Removed to make room for newer recordings." in removed_page(recording)


def test_a_recording_whose_turn_stays_without_its_person_is_seen_as_before(roles, admin_client):
    """Everybody, as the page of the turn or of the job; deleting an account leaves its turns."""
    turn = Turn.objects.get()
    recording = made(turn.grant)
    admin_client.post(f"/admin/accounts/user/{turn.user_id}/delete/", {"post": "yes"})
    assert statuses(Client(), recording) == [200] * 4
    assert "Turn of Deleted account" in removed_page(recording)


def test_the_name_goes_out_of_files_of_earlier_versions_with_the_account(
    roles, admin_client, client, django_capture_on_commit_callbacks
):
    """Nothing names who gave it; the handle in files of earlier versions goes when the account is deleted."""
    turn = Turn.objects.get()
    handle, recording, later = turn.user.username, made(turn.grant), {"id": 1, "kind": "up", "state": "accepted"}
    path = keeping.path_of(recording)
    with tape_of(recording) as (tape, _):
        for told in ({**later, "by": handle, "args": {"x": 1.5}}, later):
            tape.put(COMMANDS, ms_of(SYSTEM.now()) * 10**6, told)
    index = client.get(addresses(recording)[2])
    assert [(c.get("args"), "by" in c) for c in index.json()["commands"]] == [({"x": 1.5}, False), (None, False)]
    with django_capture_on_commit_callbacks(execute=True):
        admin_client.post(f"/admin/accounts/user/{turn.user_id}/delete/", {"post": "yes"})
    assert [m.content() for m in messages(path)] == [{**later, "args": {"x": 1.5}}, later]
    version, recording.version = recording.version, Recording.objects.get().version
    assert recording.version == version + 1 and statuses(client, recording)[1:3] == [200, 200]
    assert handle not in client.get(addresses(recording)[2]).content.decode()
    keeping.forget_names([recording.pk])
    assert Recording.objects.get().version == recording.version, "there is nothing more to take out"


def test_days_are_as_the_table_of_settings_says(settings):
    """FARHAND_FRAME_KEEP_DAYS 30; FARHAND_RECORDING_KEEP_DAYS, FARHAND_MOVIE_KEEP_DAYS 30, 3."""
    recording = settings.RECORDING
    assert (settings.FRAME_KEEP_DAYS, recording["KEEP_DAYS"], recording["MOVIE_KEEP_DAYS"]) == (30, 30, 3)


def test_what_is_old_is_removed_once_an_hour(settings):
    """the oldest are removed first, once an hour."""
    planned = {one["task"]: one["schedule"] for one in settings.CELERY_BEAT_SCHEDULE.values()}
    assert (planned["robots.clean"], planned["queueing.clean"]) == (3600.0, 3600.0)
