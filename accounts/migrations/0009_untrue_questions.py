from django.db import migrations

# they are from when pictures came only after a motion, and the age of the picture was a number that counted up
UNTRUE = {
    "When is the picture taken?": "It is taken after the arm has come to rest.",
    "What is the number beside the picture that counts up?": "It is the age of the picture: how long ago it was taken.",
    "What does each camera say beside its picture?": "Each says how old its picture is.",
}


def retire(apps, schema_editor):
    """Ask no more what is not true any more; a question that staff have written themselves stays."""
    Question = apps.get_model("accounts", "Question")
    for text, explanation in UNTRUE.items():
        Question.objects.filter(text=text, explanation=explanation).update(active=False)


class Migration(migrations.Migration):
    dependencies = [("accounts", "0008_look_alike_handles")]

    operations = [migrations.RunPython(retire, migrations.RunPython.noop)]
