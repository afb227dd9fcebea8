"""Bad input at every address is answered with a sentence and a 4xx, never a 500."""

import json
from copy import deepcopy
from itertools import product
from urllib.parse import urlencode

import pytest
from django.db import transaction

from accounts import staff
from accounts.models import Clearance
from accounts.services import load_bank
from portal.logs.lines import Line
from portal.web.pages import middleware
from robots.kit.plain import storable, whole
from tests.conftest import at_length
from tests.services.test_permissions_pages import GET

pytestmark = [pytest.mark.service, pytest.mark.django_db]

TEXTS = [
    "²",
    "٣",
    "9" * 5000,
    "1e308",
    "-1",
    "NaN",
    "\0",
    "a\0b",
    "\ud800",
    "\u202e",
    "{" * 3000,
    "[" * 3000,
    "",
    "%00",
    "'\"<>",
]
FIELDS = ["page", "robot", "attempt", "frame", "text", "do", "x_mm", "y_mm", "small.x", "small.y", "ticket", "next",
          "q1", "s1", "s²", "s" + "9" * 5000, "login", "email", "username", "password1", "password2", "note", "q", "o",
          "action", "_selected_action", "id", "setting_boxes", "setting_speed", "turn_s", "address", "camera", "name", "visibility"]  # fmt: skip


@pytest.mark.parametrize("text", ["²", "٣", "9" * 19, "9" * 5000, "-1", "+1", "1.0", " 1", "1_0", "", "\0"])
def test_what_is_no_whole_number_is_none(text):
    assert whole(text) is None


def test_whole_numbers_and_texts_that_can_be_kept():
    assert (whole("0"), whole("007"), whole("9" * 18)) == (0, 7, 10**18 - 1)
    assert storable("Grüße 🤖")
    assert not any(storable(text) for text in ("\0", "\ud83e", "a\udfff"))


def addresses(robot, turn):
    for address, _ in GET.values():
        if "logout" not in address:
            yield address.format(turn=turn.pk, robot=robot.pk, user=turn.user_id)
    yield f"/admin/robots/robot/{robot.pk}/change/"
    yield "/admin/operatorlog/entry/"


FORM = "application/x-www-form-urlencoded"
OTHERS = ("admin", "accounts", "media", "favicon.ico")


@pytest.mark.asvs("2.2.1", "16.5.1")
@pytest.mark.parametrize("rounds", [1, at_length(len(TEXTS))])
def test_promise_36_bad_input_is_answered_in_words(robot, roles, client, caplog, rounds):
    """Every field of every form gets a bad text, in each round another."""
    from queueing.models import Turn

    load_bank(robot)
    client.raise_request_exception = False
    failed = []
    asked = list(addresses(robot, Turn.objects.get()))
    if rounds == 1:  # Django's own pages of the admin and allauth's are asked at length
        asked = [a for a in asked if a.startswith(f"/admin/robots/robot/{robot.pk}/") or a.split("/")[1] not in OTHERS]
    cookies = {}
    for role in ("superuser", "operator"):
        client.force_login(roles[role])
        cookies[role] = deepcopy(client.cookies)
    for number, address in enumerate(asked):
        for shift in range(rounds):
            data = {f: TEXTS[(i + number + shift) % len(TEXTS)] for i, f in enumerate(FIELDS)}
            plain = {f: v for f, v in data.items() if storable(v)}
            # as a form of files sends it, and percent-encoded, which carries what is no text too
            encoded = urlencode({f: v.encode("utf-8", "surrogatepass") for f, v in data.items()})
            for method, *sent in (("get", plain), ("post", plain), ("post", encoded, FORM)):
                client.cookies = deepcopy(cookies["superuser" if "/admin/" in address else "operator"])
                with transaction.atomic():
                    answer = getattr(client, method)(address, *sent)
                    transaction.set_rollback(True)
                caplog.clear()  # each record keeps its request, and with it megabytes of contexts
                if answer.status_code >= 500 and answer.status_code != 503:
                    failed.append((method, address, shift, answer.status_code))
    assert failed == []


PATHS = ["/robots/{}/", "/turns/{}/", "/classic/mercury/{}/", "/classic/{}/", "/classic/mercury/{}.gif", "/media/frames/{}",
         "/admin/robots/robot/{}/change/", "/admin/robots/robot/{}/status/", "/admin/robots/robot/{}/do/stop/",
         "/admin/accounts/user/{}/change/", "/accounts/confirm-email/{}/", "/accounts/password/reset/key/{}-x/",
         "/robots/mercury/camera/{}.jpg", "/robots/mercury/camera/0/{}.jpg", "/robots/mercury/camera/{0}/{0}.jpg", "/recordings/x/{}/index.json", "/recordings/x/1/{}.bin",
         "/robots/mercury/time-lapse/{}.mp4", "/jobs/{}/", "/log/?page={}", "/log/?robot={}", "/robots/mercury/recordings/?page={}",
         "/robots/mercury/statistics/?day={}", "/robots/mercury/statistics.json?day={}", "/robots/mercury/statistics/?from={0}&to={0}", "/survey/results/?page={0}&robot={0}",
         "/survey/results.csv?robot={}", "/robots/mercury/jobs/?page={}", "/admin/accounts/user/?p={}", "/admin/accounts/user/?id__in={}", "/admin/accounts/clearance/?robot__id__exact={}",
         "/admin/autocomplete/?app_label=accounts&model_name=clearance&field_name=user&page={0}&term={0}"]  # fmt: skip


@pytest.mark.asvs("2.2.1", "16.5.1")
def test_promise_36_bad_addresses_are_answered_in_words(robot, roles, client):
    client.raise_request_exception = False
    client.force_login(roles["superuser"])
    for path, text in product(
        PATHS,
        ("%C2%B2", "9" * 5000, "9" * 25, "99999", "%00", "a%00b", "%ED%A0%80", "-1", "..%2f..", "9223372036854775808"),
    ):
        assert client.get(path.format(text)).status_code < 500, (path, text)


@pytest.mark.parametrize("path", [
    "accounts/clearance/?granted_at__", "accounts/user/?date_joined__", "robots/command/?created_at__", "queueing/job/?asked_at__",
    "operatorlog/entry/?written_at__", "queueing/ticket/?joined_at__",
])  # fmt: skip
def test_a_filter_of_a_list_that_cannot_be_is_answered_in_words(robot, roles, client, path):
    client.force_login(roles["superuser"])
    led = set()
    for lookup, value in product(
        ("year", "date__year", "iso_year", "year__gt", "year__in", "week", "day", "range", "gt", "regex", "nowhere"),
        ("9" * 25, "99999", "0", "-1", "9" * 5000, "(", "a,b", "1e308", "nan"),
    ):
        answer = client.get(f"/admin/{path}{lookup}={value}")
        assert answer.status_code in (200, 302, 400), (lookup, value)
        if answer.status_code == 302:
            led.add(answer["Location"])
    assert all(client.get(address).status_code == 200 for address in led)
    assert client.get(f"/admin/{path}year=2026").status_code == 200


@pytest.mark.parametrize("verb", ["get", "head"])
def test_a_filter_that_cannot_be_leaves_one_record_with_its_traceback(robot, roles, client, caplog, verb):
    client.force_login(roles["superuser"])
    address = "/admin/accounts/user/?date_joined__year=99999"
    assert getattr(client, verb)(address).status_code == 400
    (record,) = [one for one in caplog.records if one.name == middleware.__name__]
    assert record.levelname == "WARNING" and record.exc_info
    lines = Line("%(levelname)s %(name)s %(message)s").format(record).splitlines()
    assert "/admin/accounts/user/" in lines[0] and len("\n".join(lines)) < 5000


@pytest.mark.parametrize("query", ["", "?robot__id__exact=1"])
def test_a_fault_of_an_action_is_ours_whatever_the_list_is_filtered_by(
    robot, roles, people, client, monkeypatch, query
):
    def fault(*args):
        raise TypeError("a fault of ours")

    monkeypatch.setattr(staff, "withdraw", fault)
    client.force_login(roles["superuser"])
    act = {"action": "withdraw", "note": "x", "_selected_action": [Clearance.objects.first().pk]}
    with pytest.raises(TypeError, match="of ours"):
        client.post(f"/admin/accounts/clearance/{query}", act)
    client.raise_request_exception = False
    answer = client.post(f"/admin/accounts/clearance/{query}", act)
    assert answer.status_code == 500 and b"Something broke on our side" in answer.content


@pytest.mark.parametrize("boxes", ["[" * 3000 + "]" * 3000, "[" + "9" * 5000 + "]", '[{"name": NaN}]', "{", "9" * 5000])
def test_boxes_that_are_none_are_named(robot, client, admin_user, boxes):
    type(robot).objects.update(driver="pa10")
    client.force_login(admin_user)
    answer = client.post(f"/admin/robots/robot/{robot.pk}/change/", {"name": "x", "setting_boxes": boxes})
    assert answer.status_code == 200
    assert "setting_boxes" in answer.context["adminform"].form.errors


@pytest.mark.parametrize("name, text", [("\0", "x"), ("x", "a\0"), ("\ud800", "x"), ("x", "\udfff"), ("x" * 61, "x")])
def test_programs_that_cannot_be_kept_are_refused(robot, people, client, name, text):
    client.force_login(people["ada"])
    body = json.dumps({"name": name, "text": text})
    answer = client.post("/robots/mercury/programs/", body, content_type="application/json")
    assert answer.status_code == 400
    assert answer.json()["error"]


@pytest.mark.parametrize(
    "body",
    [
        "[" * 100_000,
        '{"id": ' + "9" * 5000 + "}",
        '{"id": 1e999}',
        "\xff",
        '{"id": ' + "9" * 300 + ', "name": "p", "text": "x"}',
    ],
)
def test_json_that_is_none_is_refused(robot, people, client, body):
    client.force_login(people["ada"])
    answer = client.post("/robots/mercury/programs/", body, content_type="application/json")
    assert answer.status_code in (400, 403)
