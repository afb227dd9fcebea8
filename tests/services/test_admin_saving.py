"""A change of a row while staff have its form open, or while they save it, is not undone by saving."""

import pytest
from django.db.models.signals import pre_save

from accounts.handles import key
from accounts.models import Clearance, User
from queueing.models import Account, Queue
from queueing.services import queue_of
from robots.kit.clock import SYSTEM
from robots.kit.packets import Changed
from robots.models import Program, Robot

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def posted(form):
    """Return the fields of a form of the admin as a browser posts them."""
    return {
        name: value for name in form.fields
        if (value := form.get_initial_for_field(form.fields[name], name)) not in (None, False)
    } | {"_save": "Save"}  # fmt: skip


@pytest.fixture
def meanwhile():
    """Do something just before a row of a model is written."""
    connected = []

    def at(model, **values):
        def change(sender, instance, **_):
            sender.objects.filter(pk=instance.pk).update(**values)

        pre_save.connect(change, sender=model, weak=False)
        connected.append((change, model))

    yield at
    for change, model in connected:
        pre_save.disconnect(change, sender=model)


def save(client, model, row, **written):
    page = f"/admin/{model._meta.app_label}/{model._meta.model_name}/{row.pk}/change/"
    shown = client.get(page)
    sets = {}
    for inline in shown.context["inline_admin_formsets"]:
        sets |= {f"{inline.formset.prefix}-{name}": n for name, n in (("TOTAL_FORMS", 0), ("INITIAL_FORMS", 0))}
    answer = client.post(page, posted(shown.context["adminform"].form) | sets | written)
    assert answer.status_code == 302, answer.context["adminform"].form.errors


def test_a_stop_is_not_undone_by_staff_who_save_the_robot(robot, admin_client, meanwhile):
    meanwhile(Robot, stop_latched=True, releases=7, reason="It was stopped.")
    save(admin_client, Robot, robot, tagline="An arm over sand")
    row = Robot.objects.get()
    assert (row.tagline, row.stop_latched, row.releases, row.reason) == ("An arm over sand", True, 7, "It was stopped.")


def test_what_the_form_contains_is_saved(robot, admin_client):
    save(admin_client, Robot, robot, turn_s=240)
    assert Robot.objects.get().turn_s == 240


def test_open_pages_are_told_when_staff_switch_cheering_off(
    robot, admin_client, monkeypatch, django_capture_on_commit_callbacks
):
    told = []
    monkeypatch.setattr("robots.bus.publishing.publish", lambda slug, event: told.append((slug, event)))
    assert robot.takes_cheers
    with django_capture_on_commit_callbacks(execute=True):
        save(admin_client, Robot, robot, cheers="")
    assert not Robot.objects.get().takes_cheers
    assert (robot.slug, Changed("robot")) in told


def test_practice_takes_no_cheers(robot):
    twin = Robot.objects.create(
        slug="twin", name="Twin", driver=robot.driver, address=f"sim:{robot.driver}", practice_for=robot,
        clearance_required=False,
    )  # fmt: skip
    assert (twin.cheers, twin.takes_cheers) == (True, False)


def test_what_a_queue_and_an_account_have_counted_is_kept(robot, people, admin_client, meanwhile):
    queue = queue_of(robot)
    account = Account.objects.create(queue=queue, user=people["ada"])
    meanwhile(Queue, virtual_time=12.0)
    meanwhile(Account, finish_tag=34.0)
    save(admin_client, Queue, queue, name="The arm's queue")
    save(admin_client, Account, account, weight=2.0)
    queue.refresh_from_db()
    account.refresh_from_db()
    assert (queue.name, queue.virtual_time) == ("The arm's queue", 12.0)
    assert (account.weight, account.finish_tag) == (2.0, 34.0)


def test_a_new_password_is_kept(people, admin_client, meanwhile):
    meanwhile(User, password="what ada has just chosen")
    save(admin_client, User, people["ada"], username="ada-l", date_joined_0="2026-01-02", date_joined_1="03:04:05")
    ada = User.objects.get(pk=people["ada"].pk)
    assert (ada.username, ada.password) == ("ada-l", "what ada has just chosen")
    assert ada.handle_key == key("ada-l"), "nobody can take a name that looks like it"


def test_a_clearance_that_was_withdrawn_stays_withdrawn(people, robot, admin_client, meanwhile):
    mine, now = Clearance.objects.get(user=people["ada"], robot=robot), SYSTEM.now()
    meanwhile(Clearance, revoked_at=now)
    save(admin_client, Clearance, mine, granted_at_0="2026-01-02", granted_at_1="03:04:05")
    mine.refresh_from_db()
    assert (mine.granted_at.year, mine.revoked_at) == (2026, now)


def test_a_program_that_is_renamed_keeps_what_its_author_wrote_meanwhile(people, robot, admin_client, meanwhile):
    program = Program.objects.create(
        robot=robot, author=people["ada"], name="square", text="an older text", changed_at=SYSTEM.now()
    )
    meanwhile(Program, text="a newer text")
    save(admin_client, Program, program, name="a square")
    program.refresh_from_db()
    assert (program.name, program.text) == ("a square", "a newer text")
