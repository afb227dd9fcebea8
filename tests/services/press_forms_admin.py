"""Forms of the admin that create something: the values for each page of a new row, and the verbs of a robot."""

from allauth.account.models import EmailAddress
from django.contrib.auth.models import Group

from accounts.models import Clearance, Question, User
from operatorlog.models import HidingReason, Round, SurveyQuestion
from queueing.models import Queue
from robots.models import Command, Grant, Robot
from robots.states import Cycle
from tests.services.admin_forms import as_sent, controls_of
from tests.services.press_forms import SECRET

CHOICES = {"choices-0-text": "Yes", "choices-0-correct": "on", "choices-1-text": "No"}
NEW = {
    Robot: {"name": "Another", "slug": "another", "driver": "irat", "address": "sim:irat"},
    Question: {"robot": "{robot}", "text": "May it move?", "topic": "", **CHOICES},
    Clearance: {"user": "{eve}", "robot": "{robot}"},
    User: {"username": "newone", "password1": SECRET, "password2": SECRET},
    Group: {"name": "Guides"},
    EmailAddress: {"user": "{eve}", "email": "eve@example.org"},
    Queue: {"name": "Another"},
    Round: {"robot": "{robot}"},
    SurveyQuestion: {"prompt": "What else?"},
    HidingReason: {"text": "It is a riddle."},
}


def new_row(model, popup=""):
    """Return what makes the form for a new row of a model; `popup`: in the window that another form's + opens."""

    def form(world):
        User.objects.create_superuser("root", "root@example.org", SECRET)
        world.people["root"] = User.objects.get(username="root")
        client = world.browser("root")
        address = f"/admin/{model._meta.app_label}/{model._meta.model_name}/add/{popup}"
        known = {"robot": world.robot.pk, "eve": world.people["eve"].pk}
        filled = {name: value.format(**known) for name, value in NEW[model].items()}
        data = as_sent(controls_of(client.get(address)), **filled, _save="Save")
        return world.form(client, address, data, {model: model.objects.count() + 1}, of="_save")

    form.__name__ = f"new_{model._meta.model_name}{popup.replace('?', '_')}"
    return form


def verb_of_staff(world, verb, of="", **data):
    page = f"/admin/robots/robot/{world.robot.pk}/"
    counts = {Command: verb != "maintenance", Grant: 1}
    return world.form(world.browser("kim"), f"{page}do/{verb}/", data, counts, f"{page}change/", of or f"/do/{verb}/")


def procedure_of_staff(world):
    return verb_of_staff(world, "procedure", 'value="soft_reset"', kind="soft_reset")


def setting_of_staff(world):
    return verb_of_staff(world, "setting", 'value="speed"', kind="speed", speed="0.3")


def test_of_connection(world):
    return verb_of_staff(world, "test")


test_of_connection.__test__ = False


def maintenance(world):
    Robot.objects.update(cycle=Cycle.LOCKED_OUT)
    return verb_of_staff(world, "maintenance")


NEW_ROWS = (*map(new_row, NEW), *(new_row(model, "?_popup=1") for model in (Group, SurveyQuestion)))
VERBS_ONCE = {
    "procedure": procedure_of_staff, "setting": setting_of_staff, "test": test_of_connection,
    "maintenance": maintenance,
}  # fmt: skip
