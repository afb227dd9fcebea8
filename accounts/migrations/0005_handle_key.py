import unicodedata

import accounts.handles
from django.db import migrations

ALIKE = str.maketrans("асеорхуіјѕԁһӏԛԝοενρικχυ", "aceopxyijsdhlqwoevpikxu")


def fill(apps, schema_editor):
    """The oldest account has the key, later ones that look the same keep their handle with a key of their own."""
    User = apps.get_model("accounts", "User")
    taken = set()
    for user in User.objects.order_by("pk").iterator():
        key = unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", user.username).strip().casefold())
        key = key.strip().translate(ALIKE)
        if key in taken:
            key = f"{key}#{user.pk}"
        taken.add(key)
        User.objects.filter(pk=user.pk).update(handle_key=key)


class Migration(migrations.Migration):
    dependencies = [("accounts", "0004_one_open_attempt_constraint")]

    operations = [
        migrations.AddField(
            model_name="user",
            name="handle_key",
            field=accounts.handles.HandleKey(editable=False, max_length=90, null=True),
        ),
        migrations.RunPython(fill, migrations.RunPython.noop),
    ]
