"""Recordings: who sees them, how long they are kept, how pictures are taken out, and their place in a backup."""

from datetime import timedelta

import pytest
from django.core.cache import cache

from accounts.models import User
from operatorlog.models import Entry, Visibility
from portal.keep import archive
from portal.keep import restore as restoring
from portal.web.recordings import views
from queueing.models import Job, JobRun, Turn
from queueing.services import Asker, ask
from robots import bus, services
from robots.grants import end_grant, start_grant
from robots.kit.clock import SYSTEM, ms_of
from robots.kit.contract.session import RobotState
from robots.kit.packets import picture_packet, state_packet
from robots.kit.recording.container import STATE, taken_ms
from robots.kit.recording.packets import picture_of, state_told
from robots.kit.recording.reading import messages
from robots.models import Frame, Movie, Recording, RecordingState, Records, Robot
from robots.recordings import cleaning, keeping
from robots.services.permissions import NotStaff
from robots.states import GrantEnd, GrantKind
from tests.services.tapes import tape_of

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("media")]
JPEG = b"\xff\xd8 a picture \xff\xd9"


def written(recording, seconds=10):
    """Write a file for a recording: a state and a picture each second, from its beginning on."""
    with tape_of(recording, {"robot": recording.robot.slug}) as (tape, began):
        for n in range(seconds):
            ms = began + 1000 * n
            state = state_packet(n, ms, RobotState(0.0, (1.0, 2.0, 0.1, 0.0), (), False, True), False)
            tape.put(STATE, ms * 10**6, state_told(state, ("q1", "q2", "q3", "q4"), ()))
            tape.put("camera/0", ms * 10**6, picture_of(picture_packet(n, ms, 0, (), JPEG)))


def made(grant, seconds=10, age=timedelta()):
    """Return a finished recording of a grant."""
    began = SYSTEM.now() - age
    recording = keeping.begin(grant, "here", began)
    written(recording, seconds)
    keeping.finish(recording, RecordingState.READY, "", began + timedelta(seconds=seconds))
    return recording


def of_turn(**more):
    turn = Turn.objects.get()
    return made(turn.grant, **more)


def addresses(recording):
    at = recording.get_absolute_url()
    version = f"{at}{recording.version}/"
    return [at, f"{at}file.mcap", f"{version}index.json", f"{version}0.bin"]


def statuses(client, recording):
    return [client.get(address).status_code for address in addresses(recording)]


def test_everybody_sees_the_recording_of_a_turn_and_finds_it_from_its_page(roles, client):
    recording = of_turn()
    assert statuses(client, recording) == [200, 200, 200, 200]
    page = client.get(f"/turns/{Turn.objects.get().pk}/").content.decode()
    assert recording.get_absolute_url() in page and "Kept until" in page
    assert recording.get_absolute_url() in client.get("/robots/mercury/recordings/").content.decode()
    index = client.get(addresses(recording)[2]).json()
    assert index["pictures"] == 10 and index["needs"] == [0, 1]


@pytest.mark.asvs("8.2.2")
def test_after_a_moderator_hid_its_entry_only_operator_and_staff_see_a_turn(roles, client):
    recording, turn = of_turn(), Turn.objects.get()
    Entry.objects.create(
        turn=turn, author=turn.user, robot=turn.robot, text="x", written_at=SYSTEM.now(), visibility=Visibility.HIDDEN
    )
    seen = {}
    for role, user in roles.items():
        client.logout()
        if user.is_authenticated:
            client.force_login(user)
        seen[role] = set(statuses(client, recording))
    may = {"operator", "viewer", "robot_staff", "superuser"}
    assert seen == {role: {200} if role in may else {404} for role in roles}
    client.logout()
    assert recording.key not in client.get("/robots/mercury/recordings/").content.decode()
    assert recording.key not in client.get(f"/turns/{turn.pk}/").content.decode()


def test_the_recording_of_a_guests_job_is_found_by_its_address_alone(shuttle, client):
    job = ask(shuttle, Asker(guest="a" * 64, network="192.0.2.1"), "go", {"x": 0.1}, SYSTEM.now())
    grant = start_grant(shuttle, GrantKind.JOB, SYSTEM.now())
    JobRun.objects.create(job=job, grant=grant)
    recording = made(grant)
    answer = client.get(recording.get_absolute_url())
    assert answer.status_code == 200 and "noindex" in answer["X-Robots-Tag"]
    assert recording.key in client.get(job.get_absolute_url()).content.decode()
    assert recording.key not in client.get("/robots/mercury/recordings/").content.decode()
    Job.objects.all().delete()  # as guests' jobs are after a while
    assert statuses(client, recording) == [404, 404, 404, 404]


def test_an_index_that_an_earlier_version_kept_empties_no_slice(roles, client):
    recording = of_turn()
    earlier = b'{"began_ms": 1, "ended_ms": 2, "needs": [0, 1], "cameras": [0], "pictures": 10}'
    cache.set(f"recording-index:{recording.pk}:{recording.version}", earlier.decode(), 600)
    answer = client.get(addresses(recording)[3])
    assert len(answer.content) > 100 and "immutable" in answer["Cache-Control"]
    cache.set(f"{views.INDEX}:{recording.pk}:{recording.version}", earlier.decode(), 600)
    answer = client.get(addresses(recording)[3])
    assert answer["Cache-Control"] == "no-store", "what may be wrong is not kept"


def test_addresses_that_are_guessed_wrongly_or_out_of_date_are_not_found(roles, client):
    recording = of_turn()
    at = recording.get_absolute_url()
    for address in ("/recordings/none/", f"{at}2/index.json", f"{at}1/2.bin", f"{at}1/{10**30}.bin", f"{at}0/0.bin"):
        assert client.get(address).status_code == 404, address
    assert client.get(f"/media/{recording.file}").status_code == 404
    assert client.get(f"/media/frames/../{recording.file}").status_code == 404
    assert client.post(at).status_code == 405


def test_a_file_that_is_gone_or_damaged_is_said_to_be_and_no_page_fails(roles, client):
    recording = of_turn()
    keeping.path_of(recording).write_bytes(b"\x00" * 100)
    assert statuses(client, recording) == [200, 200, 200, 404]
    told = client.get(addresses(recording)[2]).json()
    assert told["needs"] == [] and "nothing in the file" in told["end"]
    assert not {"places", "topics"} & told.keys()
    cache.clear()
    keeping.path_of(recording).unlink()
    assert statuses(client, recording) == [200, 404, 404, 404]


def test_a_part_of_the_file_is_served(roles, client):
    recording = of_turn()
    data, address = keeping.path_of(recording).read_bytes(), addresses(recording)[1]
    whole = client.get(address)
    assert b"".join(whole.streaming_content) == data and whole["Accept-Ranges"] == "bytes"
    part = client.get(address, headers={"Range": "bytes=5-9"})
    assert (part.status_code, b"".join(part.streaming_content)) == (206, data[5:10])
    assert part["Content-Range"] == f"bytes 5-9/{len(data)}"
    tail = client.get(address, headers={"Range": "bytes=-4"})
    assert b"".join(tail.streaming_content) == data[-4:]
    for wrong in (f"bytes={len(data)}-", "bytes=9-5", "bytes=-0", "bytes=-"):
        assert client.get(address, headers={"Range": wrong}).status_code == 416, wrong
    for odd in ("bytes=1-2,4-5", "seconds=1-2", "bytes=a-b"):
        assert client.get(address, headers={"Range": odd}).status_code == 200, odd


@pytest.mark.timed
@pytest.mark.usefixtures("one_count")
def test_too_many_requests_of_one_network_are_refused(roles, client, settings):
    recording = of_turn()
    settings.RATE_LIMITS = settings.RATE_LIMITS | {"replay": "3/m/ip"}
    found = [client.get(addresses(recording)[2]).status_code for _ in range(4)]
    assert found == [200, 200, 200, 429]


def test_people_are_told_that_they_are_recorded_and_for_how_long(roles, client):
    for records, told in ((Records.WORK, True), (Records.OFF, False)):
        Robot.objects.update(records=records, recordings_keep_days=12)
        for address in ("/robots/mercury/", "/robots/mercury/jobs/", "/classic/mercury/"):
            page = client.get(address, follow=True).content.decode()
            assert ("are recorded" in page and "for 12 days" in page) == told, address


def test_old_recordings_are_removed_and_their_pages_say_so(roles, client, settings):
    recording = of_turn(age=timedelta(days=31))
    path = keeping.path_of(recording)
    assert cleaning.clean(SYSTEM.now()) == 1
    assert not path.exists() and not path.parent.exists()
    assert "kept for 30 days" in client.get(recording.get_absolute_url()).content.decode()
    assert statuses(client, recording) == [200, 404, 404, 404]
    assert cleaning.clean(SYSTEM.now()) == 0


def test_the_oldest_are_removed_where_a_robot_has_too_many(roles, robot):
    end_grant(Turn.objects.get().grant, GrantEnd.FINISHED, "", SYSTEM.now())
    kept = []
    for days in (3, 2, 1):
        grant = start_grant(robot, GrantKind.TURN, SYSTEM.now())
        kept.append(made(grant, age=timedelta(days=days)))
        end_grant(grant, GrantEnd.FINISHED, "", SYSTEM.now())
    Recording.objects.update(size=900_000)
    Robot.objects.update(recordings_limit_mb=2)
    assert cleaning.clean(SYSTEM.now()) == 1
    assert list(Recording.objects.order_by("began_at").values_list("state", flat=True)) == ["removed", "ready", "ready"]
    Robot.objects.update(recordings_limit_mb=0)
    assert cleaning.clean(SYSTEM.now()) == 2


@pytest.mark.parametrize("left", [True, False])
def test_what_a_recorder_left_that_never_came_back_is_finished_by_housekeeping(roles, left):
    turn = Turn.objects.get()
    recording = keeping.begin(turn.grant, "a host that burnt down", SYSTEM.now())
    if left:
        written(recording)
        whole = keeping.path_of(recording).read_bytes()
        keeping.live_path(recording).write_bytes(whole[: len(whole) // 2 * 2 - 40])  # without its end
        keeping.path_of(recording).unlink()
    end_grant(turn.grant, GrantEnd.FINISHED, "", SYSTEM.now())
    cleaning.clean(SYSTEM.now())
    recording.refresh_from_db()
    assert recording.state == RecordingState.RUNNING, "its recorder may come back"
    cleaning.clean(SYSTEM.now() + timedelta(hours=2))
    recording.refresh_from_db()
    assert recording.state == (RecordingState.CUT if left else RecordingState.REMOVED)
    assert "interrupted" in recording.reason
    assert keeping.path_of(recording).exists() == left and not keeping.live_path(recording).exists()


def frame_at(robot, at):
    return Frame.objects.create(robot=robot, taken_at=at, file="frames/mercury/x.jpg")


@pytest.mark.timed
def test_a_picture_that_is_taken_down_vanishes_from_entries_recordings_and_addresses(
    roles, robot, media, client, redis_server
):
    recording, turn = of_turn(), Turn.objects.get()
    frame = frame_at(robot, recording.began_at + timedelta(seconds=5))
    (media / "frames" / "mercury").mkdir(parents=True)
    (media / frame.file).write_bytes(JPEG)
    entry = Entry.objects.create(
        turn=turn, author=turn.user, robot=robot, text="x", frame=frame, written_at=SYSTEM.now()
    )
    old, at_ms = addresses(recording), ms_of(frame.taken_at)
    shown = [(robot.slug, camera, at_ms + ms) for camera, ms in ((0, -1900), (0, 0), (0, 1900), (0, 2100), (1, 0))]
    assert all(bus.keep_shot(*one, JPEG) for one in shown)
    with pytest.raises(NotStaff):
        services.take_down(frame, turn.user)
    assert services.take_down(frame, roles["robot_staff"]) == 1
    entry.refresh_from_db()
    assert entry.frame is None and not (media / "frames/mercury/x.jpg").exists()
    recording.refresh_from_db()
    began = int(recording.began_at.timestamp() * 1000)
    left = [taken_ms(m.content()) - began for m in messages(keeping.path_of(recording)) if m.topic == "camera/0"]
    assert left == [0, 1000, 2000, 8000, 9000]
    assert len([m for m in messages(keeping.path_of(recording)) if m.topic == STATE]) == 10
    assert [client.get(address).status_code for address in old[2:]] == [404, 404]
    assert statuses(client, recording) == [200] * 4
    assert [bus.shot(*one) is not None for one in shown] == [False, False, False, True, True]


def test_what_is_taken_down_while_it_is_recorded_is_taken_out_at_the_end(roles, robot):
    turn = Turn.objects.get()
    recording = keeping.begin(turn.grant, "here", SYSTEM.now())
    services.take_down(frame_at(robot, recording.began_at + timedelta(seconds=1)), roles["robot_staff"])
    written(recording, 5)
    keeping.finish(recording, RecordingState.READY, "", SYSTEM.now() + timedelta(seconds=5))
    assert len([m for m in messages(keeping.path_of(recording)) if m.topic == "camera/0"]) == 1


@pytest.mark.asvs("8.2.1")
def test_only_staff_remove_a_recording(roles, client):
    recording = of_turn()
    asked = {"action": "remove", "_selected_action": [str(recording.pk)]}
    for role in ("viewer", "log_moderator", "operator"):
        client.force_login(roles[role])
        assert client.post("/admin/robots/recording/", asked).status_code in (302, 403)
        recording.refresh_from_db()
        assert recording.replayable, role
        with pytest.raises(NotStaff):
            services.remove_recording(recording, roles[role])
    client.force_login(roles["superuser"])
    client.post("/admin/robots/recording/", asked)
    recording.refresh_from_db()
    assert recording.state == RecordingState.REMOVED and not keeping.path_of(recording).exists()


def test_only_robots_that_say_so_are_recorded_and_only_turns_and_jobs(robot, people):
    grant = start_grant(robot, GrantKind.TURN, SYSTEM.now())
    Robot.objects.update(records=Records.OFF)
    assert keeping.to_record() == [] and keeping.slugs_recorded() == []
    Robot.objects.update(records=Records.WORK, enabled=True)
    assert keeping.to_record() == [grant]
    end_grant(grant, GrantEnd.FINISHED, "", SYSTEM.now())
    start_grant(robot, GrantKind.STAFF, SYSTEM.now())
    assert keeping.to_record() == []


def test_one_grant_has_one_recording_and_its_own_recorder_goes_on_with_it(robot):
    grant = start_grant(robot, GrantKind.TURN, SYSTEM.now())
    first = keeping.begin(grant, "one", SYSTEM.now())
    assert keeping.begin(grant, "another", SYSTEM.now()) is None
    assert keeping.begin(grant, "one", SYSTEM.now()) == first
    written(first)
    keeping.finish(first, RecordingState.CUT, "full", SYSTEM.now())
    assert keeping.begin(grant, "one", SYSTEM.now()) is None


@pytest.mark.django_db(transaction=True)
@pytest.mark.parametrize("with_files", [True, False])
def test_a_backup_has_the_recordings_or_its_restored_pages_say_that_it_has_not(roles, tmp_path, client, with_files):
    recording = of_turn()
    movie = Movie.objects.create(robot=recording.robot, recording=recording, kind="mp4", asked_at=SYSTEM.now())
    keeping.movie_path(movie).parent.mkdir()
    keeping.movie_path(movie).write_bytes(b"made again if asked for")
    data = keeping.path_of(recording).read_bytes()
    manifest = archive.write(tmp_path / "b.tar.gz", recordings=with_files)
    assert list(manifest["media"]) == [recording.file] * with_files
    keeping.path_of(recording).unlink()
    restoring.read(tmp_path / "b.tar.gz", replace=True)
    restored = Recording.objects.get()
    assert Movie.objects.count() == 0
    if with_files:
        assert keeping.path_of(restored).read_bytes() == data
        assert statuses(client, restored) == [200] * 4
    else:
        assert "not in the backup" in client.get(restored.get_absolute_url()).content.decode()


@pytest.mark.timed
@pytest.mark.usefixtures("one_count")
def test_slices_have_a_limit_of_their_own_and_lists_and_movies_are_limited_too(roles, client, settings):
    recording = of_turn()
    settings.RATE_LIMITS = settings.RATE_LIMITS | {"replay": "2/m/ip", "slices": "3/m/ip"}
    assert [client.get(addresses(recording)[3]).status_code for _ in range(4)] == [200, 200, 200, 429]
    assert [client.get("/robots/mercury/recordings/").status_code for _ in range(3)] == [200, 200, 429]
    at = recording.get_absolute_url()
    for address in (f"{at}movie.mp4", "/robots/mercury/time-lapse/2026-11-01.mp4"):
        assert client.get(address).status_code in (404, 429), address
    assert client.get(f"{at}movie.mp4").status_code == 429


def test_indexes_are_read_one_at_a_time(roles, client, monkeypatch):
    monkeypatch.setattr(views, "COLD_S", 0.01)
    recording = of_turn()
    with views.COLD:
        assert statuses(client, recording)[2:] == [503, 503]
    assert statuses(client, recording)[2:] == [200, 200]


def test_many_jobs_of_guests_do_not_hide_the_other_recordings(shuttle, client, monkeypatch):
    monkeypatch.setattr(views, "LOOKED", 1)
    for age, asker in (
        (2, Asker(guest="a" * 64, network="192.0.2.1")),
        (1, Asker(guest="b" * 64, network="192.0.2.2")),
    ):
        job = ask(shuttle, asker, "go", {"x": 0.1}, SYSTEM.now())
        grant = start_grant(shuttle, GrantKind.JOB, SYSTEM.now())
        run = JobRun.objects.create(job=job, grant=grant)
        recording = made(grant, age=timedelta(hours=age))
        end_grant(grant, GrantEnd.FINISHED, "", SYSTEM.now())
        if age == 2:
            Job.objects.filter(pk=run.job_id).update(user=User.objects.get(username="ada"))
            shown = recording
    assert shown.key in client.get("/robots/mercury/recordings/").content.decode()


def test_a_robot_that_is_recorded_keeps_for_a_day_at_least_and_says_so(roles, client):
    Robot.objects.update(records=Records.WORK, recordings_keep_days=0)
    assert "for 1 day at most" in client.get("/robots/mercury/", follow=True).content.decode()


def test_a_recording_during_which_the_time_of_day_was_set_has_no_wrong_length_in_the_list(roles, client):
    recording = of_turn()
    for by in (timedelta(days=1), -timedelta(days=1)):
        Recording.objects.update(ended_at=recording.began_at + by)
        page = client.get("/robots/mercury/recordings/").content.decode()
        assert "not known: the time of day was set" in page
