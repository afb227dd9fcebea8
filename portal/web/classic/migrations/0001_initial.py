import django.db.models.deletion
from django.conf import settings
from django.db import migrations, models


class Migration(migrations.Migration):
    """The table comes from the queues, with its rows."""

    initial = True

    dependencies = [
        ("queueing", "0008_token_to_classic"),
        ("robots", "0001_initial"),
        migrations.swappable_dependency(settings.AUTH_USER_MODEL),
    ]

    operations = [
        migrations.SeparateDatabaseAndState(
            state_operations=[
                migrations.CreateModel(
                    name="ClassicToken",
                    fields=[
                        ("id", models.BigAutoField(auto_created=True, primary_key=True, serialize=False, verbose_name="ID")),
                        ("token", models.CharField(max_length=44, unique=True)),
                        ("made_at", models.DateTimeField()),
                        ("spent_at", models.DateTimeField(blank=True, null=True)),
                        ("still", models.BigIntegerField(default=0, help_text="The picture that its page shows.")),
                        ("robot", models.ForeignKey(on_delete=django.db.models.deletion.CASCADE, related_name="+", to="robots.robot")),
                        ("user", models.ForeignKey(on_delete=django.db.models.deletion.CASCADE, related_name="+", to=settings.AUTH_USER_MODEL)),
                    ],
                ),
            ],
        ),
    ]
