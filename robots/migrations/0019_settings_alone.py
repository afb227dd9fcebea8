"""The columns that are settings now are removed; apart from moving their values, so that each is one transaction."""

from django.db import migrations

from importlib import import_module

OLD = import_module("robots.migrations.0018_settings").OLD


class Migration(migrations.Migration):
    dependencies = [("robots", "0018_settings")]

    operations = [migrations.RemoveField(model_name="robot", name=name) for name in OLD]
