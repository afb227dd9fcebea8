"""The register of finds: reports, decisions, who was first; what is still hidden is told to nobody but staff."""

import re
from datetime import timedelta

import pytest
from django.core.cache import cache
from django.db import connection
from django.test.utils import CaptureQueriesContext

from operatorlog import finds, services
from operatorlog.models import Find, Piece, Round, Visibility
from operatorlog.register import register_of
from queueing.models import Turn
from robots.kit.clock import SYSTEM
from robots.models import Command
from tests.services.conftest import ROLES
from tests.services.finds import PAGES, as_role, bed_of, confirmed, ended, reported

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def bed(robot, roles):
    return bed_of(robot)


def test_the_log_form_reports_a_find_at_the_place_of_its_picture(bed, roles):
    turn, client = ended(), as_role(roles, "operator")
    page = client.get(turn.get_absolute_url()).content.decode()
    assert re.search(r'value="\d+" data-x="10.0" data-y="40.0"', page)
    answer = client.post(
        turn.get_absolute_url(),
        {
            "text": "See below.",
            "find": " a  spoon ",
            "find_x": "",
            "find_y": "",
            "frame": str(turn.grant.frames.get().pk),
        },
    )
    assert answer.status_code == 302
    find = Find.objects.get()
    assert (find.name, find.x, find.y, find.state) == ("a spoon", 0.1, 0.4, "reported")
    assert (find.round, find.author, find.frame.kept) == (bed, roles["operator"], True)
    assert find.seen_at == find.frame.taken_at
    page = client.get(turn.get_absolute_url()).content.decode()
    assert "a spoon: waits for a moderator" in page
    german = client.get(turn.get_absolute_url(), headers={"accept-language": "de"}).content.decode()
    assert "a spoon: wartet auf die Moderation" in german
    client.post(turn.get_absolute_url(), {"find": "another", "find_x": "12", "find_y": "41,5"})
    other = Find.objects.get(name="another")
    assert (other.x, other.y, other.frame, other.seen_at) == (0.12, 0.415, None, ended().ended_at)


def test_a_second_press_reports_nothing_and_a_second_place_of_the_same_name_is_another_find(bed, roles):
    turn, client = ended(), as_role(roles, "operator")
    told = {"find": "a shard", "find_x": "12", "find_y": "40", "frame": ""}
    for _ in range(2):
        client.post(turn.get_absolute_url(), told)
    assert Find.objects.count() == 1, "a second press"
    client.post(turn.get_absolute_url(), told | {"find_y": "41,5"})
    assert {(one.x, one.y) for one in Find.objects.all()} == {(0.12, 0.4), (0.12, 0.415)}
    client.post(turn.get_absolute_url(), told | {"frame": str(turn.grant.frames.get().pk)})
    assert Find.objects.count() == 3, "another picture"


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"find": "x" * 81}, "at most 80 characters; yours are 81"),
        ({"find": "x", "find_x": "far", "find_y": "1"}, "two numbers in cm"),
        ({"find": "x", "find_x": "9" * 400, "find_y": "1"}, "two numbers in cm"),
        ({"find": "x", "find_x": "999", "find_y": "40"}, "lies in the area of the map: from -24 to 24 cm across"),
        ({"find": "x", "find_x": "1"}, "Choose the picture"),
        ({"find": "x", "frame": "999999"}, "picture of your own turn"),
        ({"find": "x\0y", "find_x": "1", "find_y": "40"}, ""),
    ],
)
def test_a_wrong_report_is_refused_in_words_and_nothing_is_lost(bed, roles, told, said):
    answer = as_role(roles, "operator").post(ended().get_absolute_url(), {"text": "my words", **told})
    assert answer.status_code in (400, 422)
    html = answer.content.decode()
    if answer.status_code == 422:
        assert said in html
        assert "my words" in html
        assert told["find"][:80] in html
    assert not Find.objects.exists()
    assert not ended().robot.entries.exists(), "all or nothing"


@pytest.mark.asvs("8.2.2")
@pytest.mark.parametrize("role", [role for role in ROLES if role != "operator"])
def test_nobody_else_reports_for_the_operator(bed, roles, role):
    answer = as_role(roles, role).post(ended().get_absolute_url(), {"find": "x", "find_x": "1", "find_y": "40"})
    assert answer.status_code in (302, 403)
    assert not Find.objects.exists()


def test_of_a_turn_that_goes_on_and_of_too_many_nothing_is_taken(bed, roles):
    Turn.objects.update(ended_at=None)
    with pytest.raises(services.LogError, match="still running"):
        reported(roles)
    Turn.objects.update(ended_at=SYSTEM.now())
    for number in range(finds.MOST_OF_A_TURN):
        reported(roles, f"find {number}")
    with pytest.raises(services.LogError, match="more are not taken"):
        reported(roles, "one more")


@pytest.mark.asvs("8.2.2")
def test_moderators_alone_decide(bed, roles):
    find = reported(roles)
    piece = Piece.objects.first()
    for role in ROLES:
        if role not in ("superuser",):
            with pytest.raises(services.LogError, match="moderators"):
                finds.decide(find, roles[role], Find.State.CONFIRMED, piece, SYSTEM.now())
    root = roles["superuser"]
    with pytest.raises(services.LogError, match="which piece"):
        finds.decide(find, root, Find.State.CONFIRMED, None, SYSTEM.now())
    other = Piece.objects.create(
        round=Round.objects.create(robot=bed.robot, number=2, began_at=SYSTEM.now(), ended_at=SYSTEM.now()), name="b"
    )
    with pytest.raises(services.LogError, match="Choose a piece of round 1"):
        finds.decide(find, root, Find.State.CONFIRMED, other, SYSTEM.now())
    assert finds.decide(find, root, Find.State.CONFIRMED, piece, SYSTEM.now())
    assert not finds.decide(find, root, Find.State.CONFIRMED, piece, SYSTEM.now()), "a second press"
    assert finds.decide(find, root, Find.State.DECLINED, piece, SYSTEM.now())
    find.refresh_from_db()
    assert (find.state, find.piece, find.decided_by) == ("declined", None, root)


def test_in_the_admin_a_find_is_confirmed_against_a_piece(bed, roles):
    find = reported(roles)
    client = as_role(roles, "superuser")
    address = f"/admin/operatorlog/find/{find.pk}/change/"
    page = client.get(address).content.decode()
    assert "zirconium spoon, 23.7 cm away" in page
    refused = client.post(address, {"state": "confirmed", "piece": ""})
    assert "Choose which piece it is." in refused.content.decode()
    assert (
        client.post(address, {"state": "confirmed", "piece": Piece.objects.get(name="zirconium spoon").pk}).status_code
        == 302
    )
    find.refresh_from_db()
    assert (find.state, find.piece.name, find.decided_by) == ("confirmed", "zirconium spoon", roles["superuser"])


def test_the_page_tells_who_was_first(bed, roles, client):
    first = confirmed(roles)
    again = confirmed(roles, "the same spoon")
    Find.objects.filter(pk=again.pk).update(seen_at=first.seen_at - timedelta(hours=1), author=None)
    html = client.get("/robots/mercury/finds/").content.decode()
    assert "1 of 2 pieces was found" in html
    assert "1 still lies hidden" in html
    assert "zirconium spoon" in html
    assert "1 more found it later" in html
    row = html[html.index("<tbody>") :]
    assert f"{again.author_name}," not in row, "the account of the first one was deleted"
    assert "x 10 cm" in html
    assert first.frame.url in html


@pytest.mark.asvs("8.2.2")
@pytest.mark.parametrize("role", ["anonymous", "signed_in", "cleared", "operator", "log_moderator", "robot_staff"])
def test_what_is_hidden_is_on_no_page_and_in_no_answer(bed, roles, role):
    """Neither its name, nor its place in m, cm or mm, nor on the map; also not of rounds that are over."""
    confirmed(roles)
    over = Round.objects.create(robot=bed.robot, number=9, began_at=SYSTEM.now(), ended_at=SYSTEM.now())
    Piece.objects.create(round=over, name="quartz thimble", x=0.1987, y=0.5123)
    client = as_role(roles, role)
    for page in PAGES:
        html = client.get(ended().get_absolute_url() if page == "turn" else page, follow=True).content.decode()
        for secret in (
            "quartz thimble",
            "thimble",
            "0.1987",
            "19.87",
            "19.9 cm",
            "198.7",
            "0.5123",
            "51.2 cm",
            "512.3",
        ):
            assert secret not in html, (page, secret)
        for secret in ("0.1234", "-12.3 cm", "123.4", "0.3217", "32.2 cm"):
            assert secret not in html, "nor the true place of one that was found"
    for table in ("find", "round", "piece"):
        answer = client.get(f"/admin/operatorlog/{table}/")
        assert answer.status_code in (302, 403, 404)


def test_a_report_that_nobody_has_confirmed_is_not_public(bed, roles, client):
    reported(roles, "a rude name")
    for page in ("/robots/mercury/finds/", ended().get_absolute_url(), "/log/"):
        assert "a rude name" not in client.get(page).content.decode()


def test_the_picture_of_a_hidden_turn_is_not_in_the_register(bed, roles, client):
    find = confirmed(roles)
    entry = services.write(ended(), roles["operator"], "rude", None, SYSTEM.now())
    assert find.frame.url in client.get("/robots/mercury/finds/").content.decode()
    services.moderate(entry, roles["superuser"], Visibility.HIDDEN, "rude", SYSTEM.now())
    html = client.get("/robots/mercury/finds/").content.decode()
    assert find.frame.url not in html
    assert "zirconium spoon" in html


def dig(turn, number, sent, **more):
    now = SYSTEM.now()
    return Command.objects.create(
        robot=turn.robot, grant=turn.grant, client_seq=5000 + number, kind="air", epoch=1, state="completed",
        created_at=now, deadline=now, ended_at=now, result={"sent": sent}, **more,
    )  # fmt: skip


def test_the_map_counts_what_was_dug_in_squares_with_one_query(bed, roles, client, robot):
    turn = ended()
    for number in range(5):
        dig(turn, number, {"seconds": 0.1, "x": 0.101, "y": 0.401})
    dig(turn, 6, {"x": 0.24, "y": 0.55})  # the last corner belongs to the last square
    dig(turn, 7, {"x": 9.0, "y": 0.4})
    dig(turn, 8, {"seconds": 0.1})
    dig(turn, 9, {"x": None, "y": 0.4})
    failed = dig(turn, 10, {"x": 0.0, "y": 0.4})
    Command.objects.filter(pk=failed.pk).update(state="failed")
    with CaptureQueriesContext(connection) as queries:
        register = register_of(robot)
    assert [(cell.count, cell.words) for cell in register.cells] == [
        (5, "about five bursts here"),
        (1, "one burst here"),
    ]
    assert len(queries) <= 6
    for number in range(20, 120):
        dig(turn, number, {"x": -0.24 + 0.004 * (number - 20), "y": 0.3})
    cache.clear()
    with CaptureQueriesContext(connection) as more:
        register_of(robot)
    assert len(more) == len(queries)
    cache.clear()
    html = client.get("/robots/mercury/finds/").content.decode()
    assert html.count("about five bursts here") >= 3, "for the pointer, the keyboard and in the table"
    assert "style=" not in html


def test_a_consoles_map_gets_squares_and_finds_in_the_readers_language_and_counts_only_after_a_burst(
    bed, roles, client
):
    turn = ended()
    for number in range(2):
        newest = dig(turn, number, {"x": 0.101, "y": 0.401})
    confirmed(roles)
    address = "/robots/mercury/dug.json"
    with CaptureQueriesContext(connection) as counted:
        told = client.get(address, headers={"Accept-Language": "en"}).json()
    with CaptureQueriesContext(connection) as again:
        assert client.get(address, headers={"Accept-Language": "en"}).json() == told
    assert len(again) == len(counted) - 1
    assert (told["cells"], told["newest"], told["found"]) == (
        [[8, 2, 2]],
        newest.pk,
        [[1, "zirconium spoon", 0.1, 0.4]],
    )
    left, low, right, high = told["area"]
    assert left + 8 * told["cell_m"] <= 0.101 < left + 9 * told["cell_m"] < right
    assert low + 2 * told["cell_m"] <= 0.401 < low + 3 * told["cell_m"] < high
    assert told["words"][:2] == ["one burst here", "about two bursts here"]
    assert told["more"] == "about {number} bursts here"
    newest = dig(turn, 3, {"x": 0.101, "y": 0.401})
    fresh = client.get(address, headers={"Accept-Language": "de"}).json()
    assert (fresh["cells"], fresh["newest"]) == ([[8, 2, 3]], newest.pk), "it is never an old one"
    assert fresh["words"][0] != told["words"][0]
    assert "{number}" in fresh["more"]
    assert "quartz" not in str(told), "what is hidden is not told"
    type(turn.robot).objects.filter(pk=turn.robot_id).update(driver="srv1")
    assert client.get(address).status_code == 404
    assert client.get("/robots/nobody/dug.json").status_code == 404


def test_before_the_first_round_the_page_counts_the_bed_of_a_simulated_robot(robot, client):
    cache.clear()
    html = client.get("/robots/mercury/finds/").content.decode()
    assert "0 of 9 pieces were found" in html
    assert not Round.objects.exists(), "looking adds nothing"
    type(robot).objects.filter(pk=robot.pk).update(address="serial:/dev/ttyUSB0")
    assert "Nothing is hidden now." in client.get("/robots/mercury/finds/").content.decode()


def test_a_robot_without_hidden_pieces_has_no_such_page(robot, client):
    type(robot).objects.filter(pk=robot.pk).update(driver="srv1")
    assert client.get("/robots/mercury/finds/").status_code == 404
    assert "/finds/" not in client.get("/robots/mercury/").content.decode()
