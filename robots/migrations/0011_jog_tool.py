"""The museum arm's command `jog_hand` is called `jog_tool`."""

from django.db import migrations


def rename(old, new):
    def forward(apps, schema_editor):
        apps.get_model("robots", "Command").objects.filter(robot__driver="pa10", kind=old).update(kind=new)

    return forward


class Migration(migrations.Migration):

    dependencies = [
        ("robots", "0010_lanes_and_progress"),
    ]

    operations = [
        migrations.RunPython(rename("jog_hand", "jog_tool"), rename("jog_tool", "jog_hand")),
    ]
