from django.db import migrations, models


class Migration(migrations.Migration):
    dependencies = [
        ("robots", "0024_stopped_after"),
    ]

    operations = [
        migrations.AddField(
            model_name="command",
            name="clamping",
            field=models.JSONField(blank=True, db_default={}, default=dict),
        ),
        migrations.AddField(
            model_name="command",
            name="newest_picture_at",
            field=models.DateTimeField(blank=True, null=True),
        ),
        migrations.AddField(
            model_name="command",
            name="seen_picture_at",
            field=models.DateTimeField(blank=True, null=True),
        ),
    ]
