from django.conf import settings
from django.db import migrations, models


class Migration(migrations.Migration):
    """Apart from the rows' own migration: PostgreSQL builds no index over rows changed in the same transaction."""

    dependencies = [
        ("accounts", "0003_one_open_attempt"),
        migrations.swappable_dependency(settings.AUTH_USER_MODEL),
    ]

    operations = [
        migrations.AddConstraint(
            model_name='attempt',
            constraint=models.UniqueConstraint(condition=models.Q(('finished_at', None)), fields=('user', 'robot'), name='one_open_attempt_a_person'),
        ),
    ]
