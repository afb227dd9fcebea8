"""Whatever staff change in the admin later, every page still shows older rows.

Each field of each model is changed through its form in the admin; rows are deleted and acted upon as far as the admin
lets staff. After each round, in which each field was changed to another value, every address is opened.
"""

from collections import defaultdict
from functools import cache

import pytest
from django.contrib import admin
from django.core.cache import cache as counts
from django.db import transaction
from django.test import Client

from accounts.models import User
from portal.live.snapshot import snapshot
from queueing.models import Job, Turn
from robots.kit.clock import SYSTEM
from robots.models import Recording, Robot
from tests.conftest import at_length
from tests.services.admin_forms import as_sent, controls_of, other_values

pytestmark = pytest.mark.django_db
# left out: cameras and /readyz, which ask a worker and Redis, and answer 503 without
ALONE = ("/", "/story/", "/status/", "/me/", "/me/places/", "/log/", "/log.atom", "/status.atom", "/survey/results/", "/survey/results.csv",
         "/accounts/email/")  # fmt: skip
OF_A_ROBOT = (
    "",
    "programs/",
    "orientation/",
    "clearance/",
    "jobs/",
    "statistics/",
    "statistics.json",
    "log.atom",
    "status.atom",
    "recordings/",
    "finds/",
)
MANY = ("robot", "surveyquestion", "queue")  # their rows differ in kind: all are changed
ROUNDS, IN_THE_GATE = 6, 2


def rows():
    """Yield model, its pages' address and some of its rows."""
    for model in admin.site._registry:
        name = model._meta.model_name
        found = model._default_manager.order_by("pk")
        yield model, f"/admin/{model._meta.app_label}/{name}/", list(found[: 3 if name in MANY else 1])


def addresses():
    """Return the addresses for everybody, and those of the admin."""
    public = [*ALONE]
    for robot in Robot.objects.all():
        public += [f"/robots/{robot.slug}/{part}" for part in OF_A_ROBOT]
        public += [f"/classic/{robot.slug}/x/", f"/log/?robot={robot.slug}"]
    public += [row.get_absolute_url() for model in (Turn, Job, Recording) for row in model.objects.all()]
    for recording in Recording.objects.all():
        at = recording.get_absolute_url()
        public += [f"{at}file.mcap", f"{at}movie.mp4", f"{at}{recording.version}/index.json"]
    staff = ["/admin/", *(f"/admin/robots/robot/{pk}/status/" for pk in Robot.objects.values_list("pk", flat=True))]
    for _, stem, found in rows():
        staff += [stem, *(f"{stem}{row.pk}/change/" for row in found)]
        staff += [f"{stem}{row.pk}/{page}/" for row in found[:1] for page in ("history", "delete")]
    return public, staff


def signed_in(name):
    client = Client(raise_request_exception=False)
    user = User.objects.filter(username=name).first()
    if user is not None:
        client.force_login(user)
    return client, user


def broken():
    """Return what answers with an error of the server, and why."""
    counts.clear()  # nobody has asked too often
    public, staff = addresses()
    found = []
    for name, asked in (("root", public + staff), ("ada", public)):
        client, user = signed_in(name)
        for address in asked:
            answer = client.get(address)
            if answer.status_code >= 500:
                why = answer.exc_info[1] if getattr(answer, "exc_info", None) else answer.status_code
                found.append((address, name, repr(why)))
        for robot in Robot.objects.all() if user else ():
            try:
                snapshot(robot.slug, user, SYSTEM.now(), True)
            except Exception as error:  # whatever it is, it would have ended the socket
                found.append((robot.slug, "its socket", repr(error)))
    return found


@cache
def changes(pages):
    """Return rounds of (page, field, value): in a round no field is changed twice."""
    client, _ = signed_in("root")
    found = defaultdict(list)
    for page in pages:
        for n, control in enumerate(controls_of(client.get(page)).values()):
            for m, value in enumerate(other_values(control)):
                found[(m + n) % ROUNDS].append((page, control.name, value))
    return found


@pytest.mark.parametrize("number", [*range(IN_THE_GATE), *map(at_length, range(IN_THE_GATE, ROUNDS))])
def test_no_field_that_staff_change_breaks_a_page(used, number):
    failed, taken = [], []
    pages = tuple(f"{stem}{row.pk}/change/" for _, stem, some in rows() for row in some)
    for page, name, value in changes(pages)[number]:
        client, _ = signed_in("root")
        form = controls_of(client.get(page))
        if name not in form:
            continue
        with transaction.atomic():
            answer = client.post(page, as_sent(form, **{name: value}))
        if answer.status_code >= 500:
            failed.append((page, name, value, repr(answer.exc_info[1])))
        elif answer.status_code == 302:
            taken.append((page, name, value))
    assert taken
    assert failed == []
    assert broken() == [], taken


DELETED_TOGETHER = (
    ("question", "group", "program", "emailaddress", "clearance", "surveyquestion", "entry", "surveyresponse", "find",
     "hidingreason"),
    ("user",), ("account", "queue", "robot"),
)  # fmt: skip


@pytest.mark.parametrize("names", DELETED_TOGETHER)
def test_no_row_that_staff_delete_breaks_a_page(used, names):
    """Of people ada is deleted, who drives; what the admin refuses to delete is told with 200 or 403."""
    client, _ = signed_in("root")
    for model, stem, found in rows():
        for row in found if model._meta.model_name in names else ():
            assert client.post(f"{stem}{row.pk}/delete/", {"post": "yes"}).status_code < 500, row
    assert broken() == []


def test_every_model_that_can_be_deleted_is_among_them(used):
    client, _ = signed_in("root")
    left = {name for names in DELETED_TOGETHER for name in names}
    for model, stem, found in rows():
        if model._meta.model_name not in left:
            assert client.get(f"{stem}{found[0].pk}/delete/").status_code == 403, model


def actions():
    """Yield address, action and row of each action on a row of the admin, but for deletion."""
    client, _ = signed_in("root")
    for model, stem, found in rows():
        request = client.get(stem).wsgi_request
        for name in admin.site._registry[model].get_actions(request):
            if name != "delete_selected":
                yield stem, name, found[0].pk


def test_no_action_of_staff_breaks_a_page_and_each_says_what_it_did(used):
    client, _ = signed_in("root")
    silent = []
    for stem, name, pk in [*actions()]:
        told = {"action": name, "_selected_action": [pk], "note": "It was pushed."}
        answer = client.post(stem, told, follow=True)
        assert answer.status_code == 200, (stem, name)
        asks = answer.request["PATH_INFO"] != stem  # on a page of its own
        if not asks and not [*answer.context["messages"]]:
            silent.append((stem, name))
    assert silent == []
    assert broken() == []
