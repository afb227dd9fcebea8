"""One field for the settings that a robot's spec declares; what staff have set in the old columns is kept."""

from django.db import migrations, models

OLD = {
    "speed": "speed",
    "boxes": "boxes",
    "stability_threshold": "still_threshold",
    "delivery_exposure_s": "still_exposure_s",
}


def moved(columns):
    """Return the settings for the old columns of one robot, by name."""
    return {new: columns[old] for old, new in OLD.items() if columns.get(old)}


def forwards(apps, schema_editor):
    robots = apps.get_model("robots", "Robot").objects
    for row in robots.values("pk", *OLD):
        robots.filter(pk=row["pk"]).update(settings=moved(row))


def backwards(apps, schema_editor):
    robots = apps.get_model("robots", "Robot").objects
    for row in robots.values("pk", "settings"):
        back = {old: row["settings"][new] for old, new in OLD.items() if new in row["settings"]}
        if back:
            robots.filter(pk=row["pk"]).update(**back)


class Migration(migrations.Migration):
    dependencies = [("robots", "0017_microphone")]

    operations = [
        migrations.AddField(
            model_name="robot",
            name="settings",
            field=models.JSONField(blank=True, db_default={}, default=dict, editable=False),
        ),
        migrations.RunPython(forwards, backwards),
    ]
