import accounts.handles
from django.db import migrations


def fill(apps, schema_editor):
    """The oldest account has the key, later ones that look the same keep their handle with a key of their own."""
    User = apps.get_model("accounts", "User")
    User.objects.update(handle_key=None)  # an old key may be the new one of somebody else
    taken = set()
    for pk, username in User.objects.order_by("pk").values_list("pk", "username"):
        key = accounts.handles.key(username)
        if key in taken:
            key = f"{key}#{pk}"
        taken.add(key)
        User.objects.filter(pk=pk).update(handle_key=key)


class Migration(migrations.Migration):
    dependencies = [("accounts", "0007_help_texts")]

    operations = [
        migrations.AlterField(
            model_name="user",
            name="handle_key",
            field=accounts.handles.HandleKey(editable=False, max_length=255, null=True, unique=True),
        ),
        migrations.RunPython(fill, migrations.RunPython.noop),
    ]
