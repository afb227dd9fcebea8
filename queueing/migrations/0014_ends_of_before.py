"""Turns that ended idle, silent or signed out before they had codes of their own, which pages tell of."""

from django.db import migrations

OLD = "absent"  # of all of them, and of connections that were lost
CODES = {
    "idle while others wait": "idle",
    "signed out": "signed_out", "the sign-in ran out": "signed_out", "password changed": "signed_out",
    "account suspended": "unfit", "clearance withdrawn": "unfit",
}  # fmt: skip


def name(apps, schema_editor):
    """Give each of these ends its code by its reason; on the classic console a lost connection was its silence."""
    grants = apps.get_model("robots", "Grant").objects.filter(kind="turn", end_code=OLD)
    for reason, code in CODES.items():
        grants.filter(end_reason=reason).update(end_code=code)
    grants.filter(end_reason="connection lost", turn__classic=True).update(end_code="silent")


def merge(apps, schema_editor):
    """Take back the codes that earlier versions do not know."""
    grants = apps.get_model("robots", "Grant").objects
    grants.filter(end_code__in=("idle", "silent", "signed_out")).update(end_code=OLD)


class Migration(migrations.Migration):
    dependencies = [
        ("queueing", "0013_turns_outlive_accounts"),
        ("robots", "0022_why_turns_end"),
    ]

    operations = [migrations.RunPython(name, merge)]
