from django.db import migrations, models


class Migration(migrations.Migration):
    dependencies = [("robots", "0027_movies_by_themselves")]

    operations = [
        migrations.AddField("recording", "of_the_day", models.CharField("movie of the day", max_length=6, choices=[("", "By the rule"), ("pinned", "Until staff say otherwise"), ("never", "Never")], default="", db_default="", blank=True)),
    ]
