"""Questions that are no longer true are not asked any more, also in a portal that has them from before."""

import pytest
from django.db import connection
from django.db.migrations.executor import MigrationExecutor

OLD = ("When is the picture taken?", "It is taken after the arm has come to rest.")

pytestmark = pytest.mark.service


@pytest.mark.django_db(transaction=True)
def test_an_update_retires_what_the_package_brought_and_leaves_what_staff_wrote(robot):
    before, after = [("accounts", "0008_look_alike_handles")], [("accounts", "0009_untrue_questions")]
    newest = MigrationExecutor(connection).loader.graph.leaf_nodes()
    try:
        MigrationExecutor(connection).migrate(before)
        apps = MigrationExecutor(connection).loader.project_state([*before, ("robots", "0021_settings_set_back")]).apps
        questions = apps.get_model("accounts", "Question").objects
        text, explanation = OLD
        for said in (explanation, "Our camera is switched on by hand."):
            questions.create(robot_id=robot.pk, text=text, explanation=said)
        questions.create(robot_id=robot.pk, text="Where is the camera?", explanation="On the arm.")
        MigrationExecutor(connection).migrate(after)
        active = dict(questions.values_list("explanation", "active"))
    finally:
        MigrationExecutor(connection).migrate(newest)
    assert active == {explanation: False, "Our camera is switched on by hand.": True, "On the arm.": True}
