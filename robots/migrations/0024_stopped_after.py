from django.db import migrations, models
from django.db.models import F, Max


def number_stops(apps, schema_editor):
    """Give each robot that was stopped the newest command of then."""
    robots, commands = apps.get_model("robots", "Robot").objects, apps.get_model("robots", "Command").objects
    for robot in robots.filter(stopped_at__isnull=False):
        newest = commands.filter(robot=robot, created_at__lte=F("robot__stopped_at")).aggregate(newest=Max("pk"))["newest"]
        robots.filter(pk=robot.pk).update(stopped_after=newest or 0)


class Migration(migrations.Migration):
    dependencies = [
        ("robots", "0023_movie_progress"),
    ]

    operations = [
        migrations.AddField(
            model_name="robot",
            name="stopped_after",
            field=models.PositiveBigIntegerField(editable=False, null=True),
        ),
        migrations.RunPython(number_stops, migrations.RunPython.noop),
    ]
