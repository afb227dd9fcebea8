from django.db import migrations, models


class Migration(migrations.Migration):
    dependencies = [("robots", "0033_labels_and_units")]

    operations = [
        migrations.AddField(
            model_name="robot",
            name="cheers",
            field=models.BooleanField(
                db_default=True, default=True, verbose_name="cheering",
                help_text="People who watch may cheer for who drives; everybody sees how many did. Not at practice.",
            ),
        ),
    ]
