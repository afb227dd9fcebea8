"""Pictures of a turn whose entry is hidden: only its author, staff and the present operator see them."""

import re

import pytest
from django.test import Client

from operatorlog import services as log
from operatorlog.models import Entry, Visibility
from portal.live.snapshot import snapshot
from portal.web.composites.views import _newest_still
from queueing import services as queue
from queueing.models import Turn
from robots.kit.clock import SYSTEM
from robots.models import Frame
from robots.states import GrantEnd

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def frames(robot, roles, settings, tmp_path):
    """Two pictures of an ended turn of the operator, one of them in the entry."""
    settings.MEDIA_ROOT = tmp_path / "media"
    turn, made = Turn.objects.get(), []
    for name in ("a", "b"):
        file = f"frames/mercury/20260101/{name}.jpg"
        (settings.MEDIA_ROOT / file).parent.mkdir(parents=True, exist_ok=True)
        (settings.MEDIA_ROOT / file).write_bytes(b"picture")
        made.append(Frame.objects.create(robot=robot, grant=turn.grant, taken_at=SYSTEM.now(), file=file))
    queue.end_turn(turn, GrantEnd.FINISHED, "", SYSTEM.now())
    turn.refresh_from_db()
    log.write(turn, roles["operator"], "something rude", made[0].pk, SYSTEM.now())
    return made


def hide(roles, visibility=Visibility.HIDDEN):
    log.moderate(Entry.objects.get(), roles["log_moderator"], visibility, "rude", SYSTEM.now())


def as_role(roles, role):
    client = Client()
    if role != "anonymous":
        client.force_login(roles[role])
    return client


SEE = {"operator": True, "log_moderator": True, "viewer": True, "robot_staff": True, "superuser": True}


def test_a_moving_picture_does_not_begin_with_a_hidden_one(robot, roles, frames):
    assert _newest_still(robot.slug) == b"picture"
    hide(roles)
    assert _newest_still(robot.slug) == b""


@pytest.mark.asvs("8.2.2")
@pytest.mark.parametrize("role", ["anonymous", "signed_in", "cleared", *SEE])
def test_a_hidden_entrys_pictures_are_gone_at_their_addresses(roles, frames, role):
    client = as_role(roles, role)
    addresses = [frame.url for frame in frames] + [
        frames[0].url.replace("/mercury/", other) for other in ("/mercury//", "/./mercury/./", "/x/../mercury/")
    ]
    for address in addresses:
        shown = client.get(address)
        assert (shown.status_code, shown["Cache-Control"]) == (200, "public, max-age=3600")
        tag = shown["ETag"]
    hide(roles)
    for address in addresses:
        for headers in ({}, {"If-None-Match": tag}):
            hidden = client.get(address, headers=headers)
            assert (hidden.status_code != 404) == SEE.get(role, False), address
            assert "public" not in hidden.get("Cache-Control", ""), address
    page = client.get(Turn.objects.get().get_absolute_url()).text
    assert (frames[1].url in page) == SEE.get(role, False)
    assert ("The pictures are hidden with the entry." in page) != SEE.get(role, False)
    hide(roles, Visibility.PUBLISHED)
    assert client.get(addresses[0]).status_code == 200


def test_no_page_shows_or_names_a_hidden_picture(robot, roles, frames):
    anybody = Client()
    classic = anybody.get("/classic/mercury/", follow=True).text.split('.gif"')[0].split('"')[-1] + ".gif"
    assert anybody.get(classic).status_code == 200
    hide(roles)
    for page in ("/", "/robots/mercury/", "/log/", "/status/"):
        answer = anybody.get(page)
        assert answer.status_code == 200
        assert not any(frame.file in answer.text for frame in frames), page
    assert anybody.get(classic).status_code == 404
    told = snapshot("mercury", roles["anonymous"], SYSTEM.now(), True)
    assert (told["still"], told["before"], told["log"]) == (None, None, [])


def test_other_sites_show_a_robots_page_with_its_newest_picture_unless_that_is_hidden(robot, roles, frames, settings):
    def card(role):
        page = as_role(roles, role).get("/robots/mercury/", headers={"X-Forwarded-Host": "evil.example"}).text
        return dict(re.findall(r'<meta property="(og:[\w:]+)" content="([^"]*)">', page))

    settings.SITE_ADDRESS = "https://robots.example.org"
    type(robot).objects.update(tagline='Digs for <b>"them"</b>')
    told = card("anonymous")
    assert (told["og:title"], told["og:url"]) == (robot.full_name, "https://robots.example.org/robots/mercury/")
    assert told["og:image"] == f"https://robots.example.org{frames[1].url}"
    assert robot.name in told["og:image:alt"]
    assert told["og:description"] == "Digs for &lt;b&gt;&quot;them&quot;&lt;/b&gt;"
    hide(roles)
    for role in ("anonymous", "log_moderator"):  # whoever follows the link may see less than who shares it
        assert "og:title" in card(role)
        assert "og:image" not in card(role), role
    type(robot).objects.update(enabled=False)
    assert card("anonymous") == {}


def test_who_drives_now_has_the_picture_to_click_in_and_the_one_before(robot, roles, frames, owned):
    """None that is older, and not the turn's page; nor does another robot's turn show anything."""
    hide(roles)
    ada, client = roles["cleared"], as_role(roles, "cleared")
    queue.join(robot, ada, SYSTEM.now())
    type(robot).objects.update(cycle="ready")
    queue.tick(SYSTEM.now())
    assert client.get(frames[1].url).status_code == 404, "before the turn"
    queue.accept(robot, ada, SYSTEM.now())
    told = snapshot("mercury", ada, SYSTEM.now(), True)
    assert (told["still"]["id"], told["before"]["id"]) == (frames[1].pk, frames[0].pk)
    assert [client.get(frame.url).status_code for frame in frames] == [200, 200]
    assert as_role(roles, "signed_in").get(frames[1].url).status_code == 404
    page = client.get(Entry.objects.get().turn.get_absolute_url()).text
    assert "The pictures are hidden with the entry." in page
    assert not any(frame.file in page for frame in frames)
    classic = client.get("/classic/mercury/", follow=True).text.split('.gif"')[0].split('"')[-1] + ".gif"
    assert client.get(classic).status_code == 200
    Frame.objects.create(robot=robot, taken_at=SYSTEM.now(), file="frames/mercury/newer.jpg")
    assert [client.get(frame.url).status_code for frame in frames] == [404, 200]
    Frame.objects.create(robot=robot, taken_at=SYSTEM.now(), file="frames/mercury/newest.jpg")
    assert [client.get(frame.url).status_code for frame in frames] == [404, 404]
    assert client.get(classic).status_code == 404
    Frame.objects.filter(file__contains="/new").delete()
    Turn.objects.filter(user=ada).update(ended_at=SYSTEM.now())
    assert [client.get(frame.url).status_code for frame in frames] == [404, 404]


def test_nobody_passes_for_the_operator_of_an_open_turn_whose_account_is_gone(roles, frames):
    hide(roles)
    Turn.objects.update(user=None, ended_at=None)
    for role in ("anonymous", "signed_in"):
        assert [as_role(roles, role).get(frame.url).status_code for frame in frames] == [404, 404]


def test_a_hidden_entry_is_not_deleted_for_its_pictures_would_be_shown_again(roles, frames):
    hide(roles)
    entry, client = Entry.objects.get(), as_role(roles, "superuser")
    assert client.post(f"/admin/operatorlog/entry/{entry.pk}/delete/", {"post": "yes"}).status_code == 403
    chosen = {"action": "delete_selected", "_selected_action": [entry.pk], "post": "yes"}
    client.post("/admin/operatorlog/entry/", chosen)
    assert Entry.objects.exists()
    assert Client().get(frames[0].url).status_code == 404
    hide(roles, Visibility.PUBLISHED)
    client.post("/admin/operatorlog/entry/", chosen)
    assert not Entry.objects.exists()


def test_what_was_hidden_stays_hidden_when_the_authors_account_is_deleted(roles, frames):
    """Nobody who is not signed in passes for the author, who is nobody now."""
    hide(roles)
    author, client = roles["operator"], as_role(roles, "superuser")
    client.post(f"/admin/accounts/user/{author.pk}/delete/", {"post": "yes"})
    entry = Entry.objects.select_related("turn").get()
    assert (entry.author, entry.visibility, entry.turn.user) == (None, Visibility.HIDDEN, None)
    for visitor in (Client(), as_role(roles, "signed_in")):
        assert [visitor.get(frame.url).status_code for frame in frames] == [404, 404]
        page = visitor.get(entry.turn.get_absolute_url()).text
        assert "Deleted account on" in page
        assert "This entry was hidden by a moderator." in page
        assert entry.text not in page
        assert visitor.post(entry.turn.get_absolute_url(), {"text": "x"}).status_code in (302, 403)
    assert as_role(roles, "superuser").get(frames[0].url).status_code == 200


def test_a_way_out_of_the_folder_is_404_without_traceback(client, caplog):
    for path in ("../secret_key", "%2e%2e/%2e%2e/etc/passwd", "..%2f..%2fetc%2fpasswd", "a/../../x"):
        assert client.get(f"/media/frames/{path}").status_code == 404, path
    assert not any(record.exc_info for record in caplog.records)
