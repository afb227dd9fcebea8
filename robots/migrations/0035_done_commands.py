from django.db import migrations, models

LABELS = {
    "queued": "Queued", "accepted": "Accepted", "sent": "Sent", "acknowledged": "Moving", "completed": "Done",
    "rejected": "Rejected", "failed": "Failed", "expired": "Expired", "cancelled": "Cancelled", "unknown": "Unknown",
}  # fmt: skip


class Migration(migrations.Migration):
    dependencies = [("robots", "0034_cheers")]

    operations = [
        migrations.AlterField(
            model_name="command",
            name="state",
            field=models.CharField(choices=list(LABELS.items()), default="queued", max_length=12),
        ),
    ]
