"""Remember that a person was told of a place that was given on; who lost one before this is not told now."""

from django.db import migrations, models
from django.db.models import F


def told(apps, schema_editor):
    apps.get_model("queueing", "Ticket").objects.filter(state="expired").update(dismissed_at=F("ended_at"))


class Migration(migrations.Migration):
    dependencies = [("queueing", "0001_initial")]
    operations = [
        migrations.AddField(
            model_name="ticket",
            name="dismissed_at",
            field=models.DateTimeField(
                blank=True, help_text="The person was told that the place was given on.", null=True
            ),
        ),
        migrations.RunPython(told, migrations.RunPython.noop, elidable=True),
    ]
