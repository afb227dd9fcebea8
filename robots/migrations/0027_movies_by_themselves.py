from django.db import migrations, models


class Migration(migrations.Migration):
    dependencies = [("robots", "0026_findings")]

    operations = [
        migrations.AddField("movie", "unasked", models.BooleanField(default=False, db_default=False, help_text="Made by itself, after those asked for.")),
        migrations.AddField("movie", "tries", models.PositiveSmallIntegerField(default=0, db_default=0, help_text="How often it could not be made.")),
        migrations.AddField("recording", "filmed", models.PositiveIntegerField(default=0, db_default=0, help_text="The version of which a movie was to be made by itself; 0: none.")),
        migrations.AddField("recording", "track", models.JSONField(default=dict, db_default={}, blank=True, help_text="Its path: driven, planned (m).")),
    ]
