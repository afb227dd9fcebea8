from django.db import migrations, models


class Migration(migrations.Migration):
    dependencies = [("robots", "0035_done_commands")]

    operations = [
        migrations.AddField(
            model_name="command",
            name="target",
            field=models.JSONField(blank=True, db_default={}, default=dict),
        ),
    ]
