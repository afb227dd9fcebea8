from django.db import migrations

from accounts.handles import claims_role
from robots.kit.plain import one_line


def clean(apps, schema_editor):
    """Names of older jobs are shown without characters that are invisible or turn the text; those of roles go."""
    Job = apps.get_model("queueing", "Job")
    for pk, name in Job.objects.exclude(shown_name="").values_list("pk", "shown_name").iterator():
        plain = one_line(name)[:40]
        if plain != name or claims_role(plain):
            Job.objects.filter(pk=pk).update(shown_name="" if claims_role(plain) else plain)


class Migration(migrations.Migration):
    dependencies = [("queueing", "0009_turn_sessions")]

    operations = [migrations.RunPython(clean, migrations.RunPython.noop)]
