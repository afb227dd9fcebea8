"""Nobody changes an account with more rights than their own, and nobody gives rights to themselves on any page."""

import pytest
from allauth.account.models import EmailAddress
from django.contrib.auth.models import Group, Permission

from accounts.models import Clearance, User
from robots.kit.clock import SYSTEM

pytestmark = pytest.mark.django_db
NEW = "a long enough phrase 9"


def staff(name, *codes, **more):
    made = User.objects.create_user(name, f"{name}@example.org", "correct horse 42", is_staff=True, **more)
    made.user_permissions.set(Permission.objects.filter(codename__in=codes))
    return User.objects.get(pk=made.pk)


@pytest.fixture
def helper(robot, people):
    """Staff for people, mails and groups, who may not touch a robot."""
    return staff("hal", *(f"{verb}_{what}" for verb in ("add", "change", "delete", "view") for what in ("user", "group", "emailaddress")))  # fmt: skip


@pytest.fixture
def above(robot, people):
    """Accounts that may do more: by themselves, by a group, only as superuser, or switched off."""
    group = Group.objects.create(name="Keepers")
    group.permissions.set(Permission.objects.filter(codename="change_robot"))
    member = staff("gus")
    member.groups.add(group)
    return {
        "own": staff("sue", "change_robot"), "group": member, "off": staff("ian", "change_robot", is_active=False),
        "root": User.objects.create_superuser("root", "root@example.org", "correct horse 42"),
        "root off": User.objects.create_superuser("roo", "roo@example.org", "correct horse 42", is_active=False),
    }  # fmt: skip


def page(user, what="change"):
    return f"/admin/accounts/user/{user.pk}/{what}/"


def filled(user, **written):
    return {
        "username": user.username, "email": user.email, "date_joined_0": "2026-01-01", "date_joined_1": "00:00:00",
        "is_active": "on", "turn_factor": user.turn_factor,
    } | written  # fmt: skip


@pytest.mark.asvs("8.3.1", "8.2.2")
@pytest.mark.parametrize("who", ["own", "group", "off", "root", "root off"])
def test_an_account_that_may_do_more_is_not_changed(client, helper, above, who):
    other = above[who]
    before = User.objects.filter(pk=other.pk).values().get()
    client.force_login(helper)
    asked = [
        (page(other), filled(other, email="taken@example.org", username="taken")),
        (page(other), filled(other) | {"is_active": ""}),
        (page(other, "password"), {"password1": NEW, "password2": NEW, "usable_password": "true"}),
        (page(other, "password"), {"usable_password": "false"}),
        (page(other, "delete"), {"post": "yes"}),
        ("/admin/accounts/user/", {"action": "delete_selected", "_selected_action": [other.pk], "post": "yes"}),
    ]
    for address, data in asked:
        answer = client.post(address, data)
        assert answer.status_code == 403 or b"doesn\xe2\x80\x99t have permission" in answer.content or b"require deleting" in answer.content or b"permission" in answer.content, address  # fmt: skip
        assert User.objects.filter(pk=other.pk).values().get() == before, address
    assert client.get(page(other)).status_code == 200, "it can be looked at"


def test_accounts_that_may_do_no_more_are_changed(client, helper, people):
    client.force_login(helper)
    equal = staff("ed", "change_user")
    for other in (people["eve"], equal, helper):
        assert client.post(page(other), filled(other, first_name="Kept")).status_code == 302
        assert User.objects.get(pk=other.pk).first_name == "Kept"
    answer = client.post(
        page(people["eve"], "password"), {"password1": NEW, "password2": NEW, "usable_password": "true"}
    )
    assert answer.status_code == 302
    assert User.objects.get(pk=people["eve"].pk).check_password(NEW)


def test_a_superuser_changes_everybody(client, above):
    client.force_login(above["root"])
    for other in (*above.values(),):
        assert (
            client.post(page(other), filled(other, first_name="Kept", is_staff="on", is_superuser="on")).status_code
            == 302
        )
        assert User.objects.get(pk=other.pk).first_name == "Kept"


@pytest.mark.parametrize("more", [(), ("add_clearance", "change_clearance", "delete_clearance", "view_clearance")])
def test_nobody_drives_with_the_account_of_somebody_who_is_cleared(client, robot, helper, people, more):
    """Staff switch such an account off; nor do those set its password who give clearances, for none to themselves."""
    helper.user_permissions.add(*Permission.objects.filter(codename__in=more))
    client.force_login(helper)
    ada = people["ada"]
    before, new = ada.password, {"password1": NEW, "password2": NEW, "usable_password": "true"}
    assert client.post(page(ada, "password"), new).status_code == 403
    assert client.post(page(ada), filled(ada, email="hal@example.org") | {"is_active": ""}).status_code == 302
    ada.refresh_from_db()
    assert (ada.password, ada.email, ada.is_active) == (before, "ada@example.org", False)
    Clearance.objects.create(user=helper, robot=robot, granted_at=SYSTEM.now())
    assert client.post(page(ada, "password"), new).status_code == 302, "cleared for the same"


def test_nobody_gives_rights_to_themselves(client, helper, people):
    client.force_login(helper)
    rights = {"is_staff": "on", "is_superuser": "on", "groups": [Group.objects.create(name="all").pk],
              "user_permissions": [p.pk for p in Permission.objects.all()]}  # fmt: skip
    for other in (helper, people["eve"]):
        client.post(page(other), filled(other) | rights)
        found = User.objects.get(pk=other.pk)
        assert not found.is_superuser
        assert not found.groups.exists()
        assert found.is_staff == (other == helper)
        assert not found.has_perm("robots.change_robot")


def test_groups_are_for_superusers(client, helper, above):
    mine = Group.objects.create(name="Helpers")
    helper.groups.add(mine)
    client.force_login(helper)
    more = {"name": "Helpers", "permissions": [p.pk for p in Permission.objects.all()]}
    assert client.post(f"/admin/auth/group/{mine.pk}/change/", more).status_code == 403
    assert client.post("/admin/auth/group/add/", more | {"name": "New"}).status_code == 403
    assert client.post(f"/admin/auth/group/{mine.pk}/delete/", {"post": "yes"}).status_code == 403
    client.post("/admin/auth/group/", {"action": "delete_selected", "_selected_action": [mine.pk], "post": "yes"})
    assert not mine.permissions.exists()
    assert Group.objects.filter(name="New").count() == 0
    assert client.get("/admin/auth/group/").status_code == 200
    client.force_login(above["root"])
    assert client.post(f"/admin/auth/group/{mine.pk}/change/", more).status_code == 302
    assert mine.permissions.exists()


def test_mail_addresses_of_accounts_are_for_superusers(client, helper, above):
    """An address of one's own at somebody else's account would bring the link to a new password."""
    old = EmailAddress.objects.create(user=above["own"], email="sue@example.org", verified=False)
    client.force_login(helper)
    mine = {"user": above["root"].pk, "email": "hal2@example.org", "verified": "on", "primary": "on"}
    assert client.post("/admin/account/emailaddress/add/", mine).status_code == 403
    assert client.post(f"/admin/account/emailaddress/{old.pk}/change/", mine).status_code == 403
    assert client.post(f"/admin/account/emailaddress/{old.pk}/delete/", {"post": "yes"}).status_code == 403
    for name in ("make_verified", "delete_selected"):
        client.post("/admin/account/emailaddress/", {"action": name, "_selected_action": [old.pk], "post": "yes"})
    old.refresh_from_db()
    assert (old.email, old.verified, EmailAddress.objects.count()) == ("sue@example.org", False, 1)
    client.force_login(above["root"])
    client.post("/admin/account/emailaddress/", {"action": "make_verified", "_selected_action": [old.pk]})
    old.refresh_from_db()
    assert old.verified


def test_nobody_clears_themselves_or_decides_on_who_may_do_more(client, robot, people, above):
    """Nor does an edit of somebody else's clearance make it one's own."""
    one = staff("clea", *(f"{verb}_clearance" for verb in ("add", "change", "delete", "view")), "view_user")
    client.force_login(one)
    at = {"granted_at_0": "2026-01-02", "granted_at_1": "03:04:05", "robot": robot.pk, "level": 1}
    own = Clearance.objects.create(user=one, robot=robot, granted_at=SYSTEM.now(), revoked_at=SYSTEM.now(), note="no")
    root = Clearance.objects.create(user=above["root"], robot=robot, granted_at=SYSTEM.now())
    eves = Clearance.objects.create(user=people["eve"], robot=robot, granted_at=SYSTEM.now())
    answers = [
        client.post("/admin/accounts/clearance/add/", at | {"user": one.pk, "level": 2}),
        client.post("/admin/accounts/clearance/add/", at | {"user": above["own"].pk}),
        client.post(f"/admin/accounts/clearance/{own.pk}/change/", at | {"user": people["bob"].pk}),
        client.post(f"/admin/accounts/clearance/{eves.pk}/change/", at | {"user": one.pk}),
        client.post(f"/admin/accounts/clearance/{root.pk}/delete/", {"post": "yes"}),
    ]
    assert [a.status_code for a in answers] == [200, 200, 403, 200, 403]
    act = {"action": "lift", "_selected_action": [own.pk], "note": "please"}
    client.post("/admin/accounts/clearance/", act)
    client.post("/admin/accounts/clearance/", act | {"action": "withdraw", "_selected_action": [root.pk]})
    for row in (own, root, eves):
        kept = (row.user_id, row.revoked_at, row.lifted_at)
        row.refresh_from_db()
        assert (row.user_id, row.revoked_at, row.lifted_at) == kept
    assert Clearance.objects.count() == 5
    assert client.post("/admin/accounts/clearance/add/", at | {"user": people["mod"].pk}).status_code == 200, (
        "mod may more"
    )
    assert client.post("/admin/accounts/clearance/add/", at | {"user": people["eve"].pk, "level": 2}).status_code == 302
    client.post("/admin/accounts/clearance/", act | {"action": "withdraw", "_selected_action": [eves.pk]})
    eves.refresh_from_db()
    assert eves.revoked_at is not None


def test_the_button_for_a_new_password_is_shown_where_it_may_be_set(client, helper, above, people):
    helper.user_permissions.add(Permission.objects.get(codename="view_user"))
    client.force_login(helper)
    for other, shown in ((people["eve"], True), (people["ada"], False), (above["root"], False)):
        answer = client.get(page(other))
        assert answer.status_code == 200
        assert ("Reset password" in answer.content.decode()) == shown
