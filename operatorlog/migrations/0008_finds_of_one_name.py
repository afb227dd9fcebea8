from django.db import migrations


class Migration(migrations.Migration):

    dependencies = [
        ('operatorlog', '0007_moderation'),
    ]

    operations = [
        migrations.RemoveConstraint(model_name='find', name='one_report_a_name_and_turn'),
    ]
