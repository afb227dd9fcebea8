"""Who may see what: every address of the URLconf by every role; an address that is in no row fails.

The admin's own views are judged by the permission that each has to want; the roles' permissions are written here.
"""

import pytest
from django.contrib import admin
from django.db import transaction
from django.urls import URLResolver, get_resolver

from queueing.models import Turn
from tests.services.conftest import ROLES

pytestmark = pytest.mark.django_db

OK, MOVED, NO, ABSENT, METHOD = 200, 302, 403, 404, 405
STAFF = ("log_moderator", "viewer", "robot_staff", "superuser")


def everybody(status):
    return dict.fromkeys(ROLES, status)


def signed_in(status, else_=MOVED):
    return {**everybody(status), "anonymous": else_}


def staff(status, else_=MOVED):
    return {role: status if role in STAFF else else_ for role in ROLES}


def only(*roles, status=OK, staff_else=NO, else_=NO):
    return {role: status if role in roles else staff_else if role in STAFF else else_ for role in ROLES}


# route: (method, address with its arguments, data, status by role)
GET = {
    "": ("/", everybody(OK)),
    "story/": ("/story/", everybody(OK)),
    "status/": ("/status/", everybody(OK)),
    "statistics/": ("/statistics/", everybody(OK)),
    "statistics.json": ("/statistics.json", everybody(OK)),
    "statistics.csv": ("/statistics.csv", everybody(OK)),
    "language/": ("/language/", everybody(METHOD)),
    "texts/<str:language>/<slug:version>.js": ("/texts/de/x.js", everybody(OK)),
    "me/": ("/me/", signed_in(OK)),
    "me/alerts/": ("/me/alerts/", everybody(METHOD)),
    "me/choices/": ("/me/choices/", everybody(METHOD)),
    "me/places/": ("/me/places/", signed_in(OK)),
    "me/push/": ("/me/push/", signed_in(OK)),
    "push-worker.js": ("/push-worker.js", everybody(OK)),
    "robots/<slug:slug>/": ("/robots/mercury/", everybody(OK)),
    "robots/<slug:slug>/drive/": ("/robots/mercury/drive/", everybody(MOVED)),
    "robots/<slug:slug>/practise/": ("/robots/mercury/practise/", everybody(METHOD)),
    "robots/<slug:slug>/model.urdf": ("/robots/mercury/model.urdf", everybody(ABSENT)),
    # who gets a code: tests/faults/test_operator_stream.py
    "robots/<slug:slug>/stream-code/": ("/robots/mercury/stream-code/", everybody(METHOD)),
    "robots/<slug:slug>/programs/": ("/robots/mercury/programs/", everybody(OK)),
    "robots/<slug:slug>/orientation/": ("/robots/mercury/orientation/", everybody(OK)),
    "robots/<slug:slug>/orientation/<slug:look>.webp": (
        "/robots/mercury/orientation/wide-light.webp", everybody(OK),
    ),
    "robots/<slug:slug>/clearance/": ("/robots/mercury/clearance/", everybody(MOVED)),
    "robots/<slug:slug>/jobs/": ("/robots/mercury/jobs/", everybody(OK)),
    "robots/<slug:slug>/statistics/": ("/robots/mercury/statistics/", everybody(ABSENT)),
    "robots/<slug:slug>/statistics.json": ("/robots/mercury/statistics.json", everybody(ABSENT)),
    "robots/<slug:slug>/live/<slug:name>.mjpg": ("/robots/mercury/live/desktop.mjpg", everybody(ABSENT)),
    "robots/<slug:slug>/camera/<int:number>.mjpg": ("/robots/mercury/camera/9.mjpg", everybody(ABSENT)),
    "robots/<slug:slug>/camera/<int:number>.jpg": ("/robots/mercury/camera/9.jpg", everybody(ABSENT)),
    "robots/<slug:slug>/camera/<int:number>/<int:at_ms>.jpg": ("/robots/mercury/camera/0/1.jpg", everybody(ABSENT)),
    "robots/<slug:slug>/recordings/": ("/robots/mercury/recordings/", everybody(OK)),
    "movie-of-the-day/": ("/movie-of-the-day/", everybody(OK)),
    # who sees one that exists: test_recordings.py
    "recordings/<str:key>/": ("/recordings/none/", everybody(ABSENT)),
    "recordings/<str:key>/movie/": ("/recordings/none/movie/", everybody(METHOD)),
    "recordings/<str:key>/movie.mp4": ("/recordings/none/movie.mp4", everybody(ABSENT)),
    "recordings/<str:key>/movie.webm": ("/recordings/none/movie.webm", everybody(ABSENT)),
    "robots/<slug:slug>/time-lapse/": ("/robots/mercury/time-lapse/", everybody(METHOD)),
    "robots/<slug:slug>/time-lapse/<str:day>.mp4": ("/robots/mercury/time-lapse/2026-01-01.mp4", everybody(ABSENT)),
    "robots/<slug:slug>/time-lapse/<str:day>.webm": ("/robots/mercury/time-lapse/x.webm", everybody(ABSENT)),
    "recordings/<str:key>/file.mcap": ("/recordings/none/file.mcap", everybody(ABSENT)),
    "recordings/<str:key>/<int:version>/index.json": ("/recordings/none/1/index.json", everybody(ABSENT)),
    "recordings/<str:key>/<int:version>/<int:number>.bin": ("/recordings/none/1/0.bin", everybody(ABSENT)),
    # who sees what of one that exists: test_moments.py
    "recordings/<str:key>/<int:version>/moment-<int:second>.jpg": ("/recordings/none/1/moment-1.jpg", everybody(ABSENT)),
    "embed/recordings/<str:key>/": ("/embed/recordings/none/", everybody(ABSENT)),
    "embed/robots/<slug:slug>/": ("/embed/robots/mercury/", everybody(OK)),
    "oembed/": ("/oembed/", everybody(400)),
    "jobs/<str:key>/": ("/jobs/none/", everybody(ABSENT)),
    "classic/<slug:slug>/": ("/classic/mercury/", everybody(MOVED)),
    "classic/<slug:slug>/<str:token>/": ("/classic/mercury/x/", everybody(OK)),
    "classic/<slug:slug>/<str:name>.gif": ("/classic/mercury/none.gif", everybody(ABSENT)),
    "log/": ("/log/", everybody(OK)),
    "log.atom": ("/log.atom", everybody(OK)),
    "status.atom": ("/status.atom", everybody(OK)),
    "robots/<slug:slug>/log.atom": ("/robots/mercury/log.atom", everybody(OK)),
    "robots/<slug:slug>/status.atom": ("/robots/mercury/status.atom", everybody(OK)),
    "robots/<slug:slug>/finds/": ("/robots/mercury/finds/", everybody(OK)),
    "robots/<slug:slug>/dug.json": ("/robots/mercury/dug.json", everybody(OK)),
    "turns/<int:pk>/": ("/turns/{turn}/", everybody(OK)),
    "survey/results/": ("/survey/results/", only("log_moderator", "viewer", "superuser")),
    "survey/results.csv": ("/survey/results.csv", only("log_moderator", "viewer", "superuser")),
    "accounts/login/": ("/accounts/login/", {**everybody(MOVED), "anonymous": OK}),
    "accounts/logout/": ("/accounts/logout/", signed_in(OK)),
    "accounts/inactive/": ("/accounts/inactive/", everybody(OK)),
    "accounts/signup/": ("/accounts/signup/", {**everybody(MOVED), "anonymous": OK}),
    "accounts/reauthenticate/": ("/accounts/reauthenticate/", signed_in(OK)),
    "accounts/email/": ("/accounts/email/", signed_in(OK)),
    "accounts/confirm-email/": ("/accounts/confirm-email/", everybody(OK)),
    "accounts/confirm-email/<str:key>/": ("/accounts/confirm-email/wrong/", everybody(OK)),
    "accounts/send-again/": ("/accounts/send-again/", everybody(METHOD)),
    "accounts/password/change/": ("/accounts/password/change/", signed_in(OK)),
    "accounts/password/set/": ("/accounts/password/set/", everybody(MOVED)),
    "accounts/password/reset/": ("/accounts/password/reset/", everybody(OK)),
    "accounts/login/code/confirm/": ("/accounts/login/code/confirm/", everybody(MOVED)),
    "accounts/^confirm-email/(?P<key>[-:\\w]+)/$": ("/accounts/confirm-email/wrong/", everybody(OK)),
    "accounts/password/reset/key/done/": ("/accounts/password/reset/key/done/", everybody(OK)),
    "accounts/^password/reset/key/(?P<uidb36>[0-9A-Za-z]+)-(?P<key>.+)/$": (
        "/accounts/password/reset/key/1-wrong/", everybody(OK),
    ),
    "accounts/password/reset/done/": ("/accounts/password/reset/done/", everybody(OK)),
    "admin/": ("/admin/", staff(OK)),
    "admin/live/": ("/admin/live/", staff(OK)),
    "admin/login/": ("/admin/login/", staff(MOVED, NO) | {"anonymous": MOVED}),
    "admin/logout/": ("/admin/logout/", staff(METHOD, MOVED)),
    "admin/password_change/": ("/admin/password_change/", staff(OK)),
    "admin/password_change/done/": ("/admin/password_change/done/", staff(OK)),
    "admin/operatorlog/entry/review/": (
        "/admin/operatorlog/entry/review/", only("log_moderator", "superuser", else_=MOVED),
    ),
    # what it does with a round that exists: test_bury_again.py
    "admin/operatorlog/round/<int:pk>/bury/": (
        "/admin/operatorlog/round/0/bury/", only("superuser", status=ABSENT, else_=MOVED),
    ),
    "admin/autocomplete/": (
        "/admin/autocomplete/?app_label=accounts&model_name=clearance&field_name=user",
        only("viewer", "superuser", else_=MOVED),
    ),
    "admin/jsi18n/": ("/admin/jsi18n/", staff(OK)),
    "admin/r/<path:content_type_id>/<path:object_id>/": ("/admin/r/0/0/", staff(ABSENT)),
    "admin/robots/robot/<int:pk>/status/": (
        "/admin/robots/robot/{robot}/status/", only("viewer", "robot_staff", "superuser", else_=MOVED),
    ),
    "admin/robots/robot/<int:pk>/do/<str:verb>/": ("/admin/robots/robot/{robot}/do/stop/", staff(MOVED)),
    "admin/accounts/user/<id>/password/": ("/admin/accounts/user/{user}/password/", only("superuser", else_=MOVED)),
    "admin/^(?P<app_label>robots|accounts|auth|account|queueing|operatorlog|alerts)/$": (
        "/admin/robots/", only("viewer", "robot_staff", "superuser", staff_else=ABSENT, else_=MOVED),
    ),
    "admin/(?P<url>.*)$": ("/admin/nothing/here/", staff(ABSENT)),
    "media/frames/<path:path>": ("/media/frames/none.jpg", everybody(ABSENT)),
    "favicon.ico": ("/favicon.ico", everybody(MOVED)),
    "livez": ("/livez", everybody(OK)),
    "readyz": ("/readyz", everybody(OK)),
}  # fmt: skip
# what a POST does, where one does anything; addresses of allauth answer for themselves in test_doors
POST = [
    ("/robots/mercury/programs/", '{"name": "p", "text": "down"}', signed_in(OK, NO)),
    ("/robots/mercury/orientation/", {}, {**everybody(MOVED), "anonymous": OK}),
    ("/robots/mercury/clearance/", {"attempt": "1"}, everybody(MOVED)),
    ("/robots/mercury/practise/", {}, everybody(ABSENT)),  # who practises where one may: test_practice.py
    ("/classic/mercury/x/", {"do": "stop"}, everybody(MOVED)),
    ("/robots/mercury/jobs/", {"kind": "go", "arg-x": "0"}, everybody(400)),
    ("/recordings/none/movie/", {"kind": "mp4"}, everybody(ABSENT)),
    ("/robots/mercury/time-lapse/", {"day": "x", "kind": "mp4"}, everybody(MOVED)),
    ("/language/", {"language": "de"}, everybody(MOVED)),
    ("/me/alerts/", {}, {**everybody(NO), "anonymous": MOVED, "robot_staff": MOVED, "superuser": MOVED}),
    ("/me/choices/", {"do": "name"}, everybody(MOVED)),
    ("/me/choices/", {"do": "mail", "on": "on"}, everybody(MOVED)),
    ("/me/places/", {"do": "accept", "robot": "mercury"}, everybody(MOVED)),
    ("/me/push/", {"do": "stop"}, everybody(MOVED)),
    ("/turns/{turn}/", {"text": "x"}, {**everybody(NO), "anonymous": MOVED, "operator": 422}),
    ("/turns/{turn}/", {"appeal": "x"}, {**everybody(ABSENT), "anonymous": MOVED}),
    # who decides and undoes what there is: test_moderation.py
    ("/admin/operatorlog/entry/review/", {"undo": "1"}, only("log_moderator", "superuser", status=ABSENT, else_=MOVED)),
    ("/admin/operatorlog/round/0/bury/", {"puzzle": "x"}, only("superuser", status=ABSENT, else_=MOVED)),
    ("/admin/robots/robot/{robot}/do/lock_out/", {"note": "x"}, only("robot_staff", "superuser", status=MOVED, else_=MOVED)),
]  # fmt: skip


def routes(patterns, before=""):
    for one in patterns:
        route = before + str(one.pattern)
        if isinstance(one, URLResolver):
            yield from routes(one.url_patterns, route)
        else:
            yield route


def generated():
    """Return the admin's own addresses: route, model, action."""
    for model, site in admin.site._registry.items():
        stem = f"admin/{model._meta.app_label}/{model._meta.model_name}/"
        for action, tail in (("changelist", ""), ("add", "add/"), ("history", "<path:object_id>/history/"),
                             ("delete", "<path:object_id>/delete/"), ("change", "<path:object_id>/change/"),
                             ("", "<path:object_id>/")):  # fmt: skip
            yield stem + tail, site, action


@pytest.mark.asvs("8.2.1")
def test_promise_35_every_address_is_in_the_table():
    found = [*routes(get_resolver().url_patterns)]
    listed = [*GET, *(route for route, _, _ in generated())]
    assert sorted(set(found)) == sorted(set(listed))


@pytest.fixture
def clients(roles, client):
    made = {}
    for role, user in roles.items():
        made[role] = type(client)()
        if user.is_authenticated:
            made[role].force_login(user)
    return made


def statuses(clients, robot, method, address, *data):
    found = {}
    turn = Turn.objects.get()
    for role, one in clients.items():
        with transaction.atomic():
            kind = {"content_type": "application/json"} if data and isinstance(data[0], str) else {}
            found[role] = getattr(one, method)(
                address.format(turn=turn.pk, robot=robot.pk, user=turn.user_id), *data, **kind
            ).status_code
            transaction.set_rollback(True)
    return found


def test_promise_35_pages_by_roles(robot, clients):
    found = {route: statuses(clients, robot, "get", address) for route, (address, _) in GET.items()}
    assert found == {route: expected for route, (_, expected) in GET.items()}


def test_promise_35_posts_by_roles(robot, clients):
    found = {address: statuses(clients, robot, "post", address, data) for address, data, _ in POST}
    assert found == {address: expected for address, _, expected in POST}


WANTS = {"changelist": "view", "history": "view", "change": "view", "add": "add", "delete": "delete"}


@pytest.mark.asvs("8.2.1")
def test_promise_35_admin_by_roles(robot, roles, clients):
    """A person without the permission gets no page of the admin; who has it gets it, and history is never added to."""
    for route, site, action in generated():
        if not action:
            continue
        model = site.model
        obj = model._default_manager.first()
        if obj is None and "<path" in route:
            continue
        address = "/" + route.replace("<path:object_id>", str(obj.pk if obj else 0))
        for role, one in clients.items():
            user, status = roles[role], one.get(address).status_code
            perm = f"{model._meta.app_label}.{WANTS[action]}_{model._meta.model_name}"
            changes = perm.replace(".view_", ".change_")
            if not (user.is_authenticated and user.is_staff):
                assert status == MOVED, (address, role)
            elif not (user.has_perm(perm) or user.has_perm(changes)):
                assert status == NO, (address, role)
            elif WANTS[action] == "view":
                assert status == OK, (address, role)
            else:
                assert status in (OK, NO), (address, role)


ACTIONS = [
    ("operatorlog/entry", "publish"), ("operatorlog/entry", "feature"), ("queueing/turn", "end"),
    ("queueing/ticket", "remove"), ("robots/incident", "close"), ("robots/program", "take_in"),
    ("robots/recording", "remove"), ("robots/frame", "take_down"), ("accounts/clearance", "withdraw"), ("accounts/clearance", "lift"),
]  # fmt: skip


@pytest.mark.asvs("8.2.1")
def test_promise_35_actions_without_the_permission_are_refused(roles, clients):
    for where, action in ACTIONS:
        answer = clients["viewer"].post(f"/admin/{where}/", {"action": action, "_selected_action": ["1"]})
        assert answer.status_code == NO, (where, action)
