"""The steps of a turn's page: each command in words, its outcome, the picture after it, the replay at its moment."""

import re

import pytest
from django.db import connection
from django.test.utils import CaptureQueriesContext

from operatorlog import services as log
from operatorlog.models import Visibility
from operatorlog.steps import ON_A_PAGE, steps_of
from queueing import services as queue
from queueing.models import Turn
from robots.models import Command, Frame, Grant, Recording
from robots.states import GrantEnd
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]
HOME = (0.0, 0.42, 0.075, 0.0)


@pytest.fixture
def story(robot, people, owned, clock):
    """Tell the story of ada's turn: `story.did` adds a command, `story.saw` a picture; each happens a second later."""
    return Story(robot, drive(robot, people["ada"], clock.now()), clock)


class Story:
    """Rows of one turn."""

    def __init__(self, robot, turn, clock):
        self.robot, self.turn, self.clock, self.number = robot, turn, clock, 0

    def did(self, kind, args=None, state="completed", pose=None, **more):
        """Add a command that took half a second; with `pose`, its own picture."""
        self.number, now = self.number + 1, self.clock.go(1)
        begun = state not in ("rejected", "expired", "queued")
        made = Command.objects.create(
            robot=self.robot, grant=self.turn.grant, client_seq=self.number, kind=kind, args=args or {}, epoch=5,
            state=state, created_at=now, deadline=now, accepted_at=now if begun else None,
            sent_at=now if begun else None, ended_at=self.clock.go(0.5), **more,
        )  # fmt: skip
        if pose is not None:
            self.saw(pose, made)
        return made

    def saw(self, pose, command=None):
        """Add a picture."""
        now = self.clock.go(0.1)
        return Frame.objects.create(
            robot=self.robot, grant=self.turn.grant, command=command, taken_at=now, pose=list(pose), stable=True,
            file=f"frames/{self.robot.slug}/{self.clock.now():%H%M%S%f}.jpg",
        )  # fmt: skip

    def steps(self, page=None):
        """Return the steps of a page."""
        return steps_of(self.turn, page)[0]

    def end(self):
        """End the turn."""
        queue.end_turn(self.turn, GrantEnd.FINISHED, "", self.clock.now())
        return Turn.objects.get(pk=self.turn.pk)


def test_each_command_is_told_from_where_the_robot_was_before_with_its_own_picture(story):
    story.saw(HOME)
    a = story.did("move", {"x": 0.12, "y": 0.46}, pose=(0.12, 0.46, 0.075, 0.0))
    b = story.did("air", {"seconds": 0.4}, pose=(0.12, 0.46, 0.0, 0.0))
    story.did("move", {"x": 9.0, "y": 0.46}, "rejected", reason="It is outside.")
    c = story.did("move", {"x": 0.02, "y": 0.45}, pose=(0.02, 0.45, 0.075, 0.0))
    steps = story.steps()
    assert [one.words for one in steps] == [
        "Move to 12 cm right, 4 cm up", "Blow air for 0.4 s", "Move to 8.88 m right", "Move to 10 cm left, 1 cm down",
    ]  # fmt: skip
    assert [one.frame and one.frame.command_id for one in steps] == [a.pk, b.pk, None, c.pk]
    assert [one.outcome for one in steps] == ["Done", "Done", "Rejected: It is outside.", "Done"]
    assert [one.bad for one in steps] == [False, False, True, False]


def test_where_something_moved_it_unseen_a_place_is_told_as_it_was_asked(story):
    story.saw(HOME)
    story.did("up", state="failed")
    story.did("move", {"x": 0.12, "y": 0.46}, pose=(0.12, 0.46, 0.075, 0.0))
    assert story.steps()[1].words == "Move: x 12 cm, y 46 cm"


@pytest.mark.parametrize("moved", [False, True])
def test_the_first_command_is_told_from_the_picture_before_the_turn_unless_something_moved_since(story, moved):
    now = story.clock.now()
    Frame.objects.create(robot=story.robot, taken_at=now, pose=list(HOME), file="frames/a.jpg")
    if moved:
        grant = Grant.objects.create(robot=story.robot, kind="staff", opened_at=now, ended_at=now)
        Command.objects.create(
            robot=story.robot, grant=grant, client_seq=1, kind="up", epoch=5, state="failed", created_at=now, deadline=now,
            accepted_at=now, ended_at=story.clock.go(1),
        )  # fmt: skip
    story.did("move", {"x": 0.12, "y": 0.46})
    assert story.steps()[0].words == ("Move: x 12 cm, y 46 cm" if moved else "Move to 12 cm right, 4 cm up")


def test_a_command_without_a_picture_of_its_own_has_the_first_after_its_end_and_before_the_next(story):
    early = story.saw(HOME)
    first = story.did("down")
    late = story.saw(HOME)
    story.saw(HOME)
    story.did("up")
    story.did("up")
    assert [one.frame for one in story.steps()] == [late, None, None]
    assert early.taken_at < first.ended_at


def test_jogs_that_follow_each_other_are_one_step_with_how_far_they_came(story):
    story.saw(HOME)
    for n in range(1, 301):
        story.did("jog", {"dx": 1.0, "dy": 0.0}, pose=(0.0 + 0.0005 * n, 0.42, 0.075, 0.0))
    story.did("jog", {"dx": 0.0, "dy": -1.0}, "cancelled", pose=(0.15, 0.40, 0.075, 0.0), reason="Stopped.")
    story.did("up", pose=(0.15, 0.40, 0.075, 0.0))
    story.did("jog", {"dx": 0.0, "dy": -1.0})
    jogs, up, last = story.steps()
    assert (jogs.words, jogs.count) == ("Small steps, 301 times: 15 cm right, 2 cm down in all", 301)
    assert jogs.outcome == "Done 300, Cancelled 1: Stopped."
    assert (up.words, last.words) == ("Raise the camera", "Small steps: down")
    assert jogs.frame.command_id == jogs.last.pk


def test_hundreds_of_commands_are_on_pages_with_a_bounded_number_of_queries(story, client):
    for _ in range(3):
        story.did("air", pose=HOME)
    with CaptureQueriesContext(
        connection,
    ) as few:
        assert len(story.steps()) == 3
    for _ in range(3 * ON_A_PAGE):
        story.did("air", pose=HOME)
    with CaptureQueriesContext(connection) as many:
        assert len(story.steps()) == ON_A_PAGE
    assert len(many) <= len(few) + 1
    assert [one.number for one in story.steps(4)] == [3 * ON_A_PAGE + n for n in (1, 2, 3)]
    turn = story.end()
    html = client.get(f"{turn.get_absolute_url()}?page=2").content.decode()
    assert f'id="step-{ON_A_PAGE + 1}"' in html
    assert f'id="step-{ON_A_PAGE}"' not in html
    assert "?page=1#commands" in html
    assert "?page=3#commands" in html
    assert html.count('loading="lazy"') == html.count("<img") - html.count('id="stepper-picture"')
    for wrong in ("0", "x", "9" * 400, "-1"):
        assert client.get(turn.get_absolute_url(), {"page": wrong}).status_code == 200


def test_the_page_says_what_each_picture_shows(story, client):
    story.saw(HOME)
    frame = Frame.objects.get(command=story.did("move", {"x": 0.12, "y": 0.46}, pose=(0.12, 0.46, 0.075, 0.0)))
    html = client.get(story.end().get_absolute_url()).content.decode()
    shown = re.search(rf'<img src="{frame.url}" alt="([^"]+)"', html)
    assert shown[1] == f"Picture {frame.taken_at:%H:%M:%S}, after: Move to 12 cm right, 4 cm up"


def test_the_page_of_an_arms_turn_tells_joints_by_plain_words_and_places_from_the_base(story, client):
    type(story.robot).objects.update(driver="pa10")
    story.did("joints", {"S1": 0.2967, "S2": 0.4, "speed": 0.3})
    story.did("pick", {"x": 0.5, "y": 0.16})
    html = client.get(story.end().get_absolute_url()).content.decode()
    assert "Move joints: shoulder turn 17°, shoulder 23°, 30 % of full speed" in html
    assert "Pick up here: 50 cm ahead of the base, 16 cm to its left" in html
    assert not re.search(r"S1 17°|S2 |speed 0\.3|x 50 cm", html)


def test_pictures_of_a_hidden_entry_are_not_beside_the_commands(story, people, client, clock):
    frame = Frame.objects.get(command=story.did("air", pose=HOME))
    entry = log.write(story.end(), people["ada"], "rude", None, clock.now())
    log.moderate(entry, people["mod"], Visibility.HIDDEN, "rude", clock.now())
    page = entry.turn.get_absolute_url()
    for who, sees in (("ada", True), ("mod", True), ("bob", False), (None, False)):
        client.logout()
        if who:
            client.force_login(people[who])
        html = client.get(page).content.decode()
        assert (frame.file in html) == sees, who
        assert "Blow air" in html


def test_a_command_links_to_its_moment_in_the_recording(story, client, clock):
    began = clock.now()
    story.did("air", pose=HOME)
    turn = story.end()
    page = turn.get_absolute_url()
    assert "Replay from here" not in client.get(page).content.decode()
    Recording.objects.create(
        robot=story.robot, grant=turn.grant, key="k" * 22, state="ready", file="recordings/a.mcap", began_at=began,
        ended_at=clock.go(9),
    )  # fmt: skip
    html = client.get(page).content.decode()
    assert f'href="/recordings/{"k" * 22}/#at=0.0"' in html
    assert "data-replays" in html, "no stepper beside it"


def test_a_robot_whose_package_is_gone_has_its_commands_by_their_names(story):
    story.did("air", pose=HOME)
    story.robot.driver = story.turn.robot.driver = "gone"
    assert [one.words for one in story.steps()] == ["air"]
