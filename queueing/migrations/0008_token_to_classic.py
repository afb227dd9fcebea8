from django.db import migrations


class Migration(migrations.Migration):
    """The table of the tokens belongs to the console without scripts; its rows stay."""

    dependencies = [("queueing", "0007_job_end_codes")]

    operations = [
        migrations.SeparateDatabaseAndState(
            database_operations=[migrations.AlterModelTable("ClassicToken", "classic_classictoken")],
            state_operations=[migrations.DeleteModel("ClassicToken")],
        ),
    ]
