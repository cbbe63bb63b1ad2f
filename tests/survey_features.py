"""Descriptors and features of the survey's screws, written anew after their definition changed; nothing is solved in 3D.

``python -m tests.survey_features`` draws every screw of ``compare/references/survey.json`` again and solves it by the two
low-order models (five minutes of one core); measured errors and loads of the record stay.
"""

from rollbench.compare.models.applicability import DESCRIPTORS, SURVEY
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.model_form import features_of_scene
from rollbench.compare.models.registry import run_model
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes import scene_file
from rollbench.compare.studies import survey
from rollbench.compare.studies.survey import random_screw_scene_text


def main() -> None:
    """Write the record."""
    found = survey.built_in_survey()
    for row in found["scenes"]:
        name = f"survey-{found['seed']}-{row['number']}.toml"
        scene = scene_file.scene_from_text(random_screw_scene_text(found["seed"], row["number"]), name)
        if "points" in row:
            row["places"] = {d.name: round(d.value_of_scene(scene), 4) for d in DESCRIPTORS}
        for point in row.get("points", ()):
            result = run_model(scene, point["model"], ModelOptions(estimate_beam_mesh_error=False))
            point["features"] = {name: round(value, 4) for name, value in features_of_scene(scene, result).items()}
    (shipped_store() / SURVEY).write_text(survey.survey_records_as_json(found["seed"], found["scenes"]), encoding="utf-8")


if __name__ == "__main__":
    main()
