"""The live page of a scene: a shape at rest that follows its sliders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lumpedcable.page.controls import Model, chosen
from lumpedcable.page.document import document
from lumpedcable.page.elastic import elastic_model
from lumpedcable.page.highline import SceneHighline, highline_of
from lumpedcable.page.server import Answer
from lumpedcable.page.stages import stage_models
from lumpedcable.page.surroundings import surroundings
from lumpedcable.results.ground import tables
from lumpedcable.scene import Study
from lumpedcable.scene.writer import to_toml

__all__ = ["live_page"]


def live_page(study: Study, run: int = 0) -> tuple[str, dict[str, Answer]]:
    """The page of a scene at rest and what answers it.

    A highline has its stages in closed form and itself through the engine; any other scene has itself.

    Args:
        study: the scene as read.
        run: which run of its sweep.

    Returns:
        The HTML text, and by path what answers the JSON {"model": key, "values": {key: number}}:
        /solve with lines, points, numbers and equations, /toml with the scene's text.

    Raises:
        SceneError: the scene cannot be laid out.
    """
    scene = study.runs[run]
    highline = highline_of(scene)
    models = {model.key: model for model in _models(study, run, highline)}
    head = {
        "kind": "live",
        "title": scene.title or Path(study.path).stem,
        "file": Path(study.path).name,
        "models": [model.head() for model in models.values()],
        # the scene itself, unless a stage has its numbers and has them at once
        "first": "scene" if highline is None else highline.stage or "scene",
        "surroundings": surroundings(tables(to_toml(scene))),
    }

    def solve(asked: Any) -> dict[str, Any]:
        model, values = chosen(models, asked)
        return model.solve(values)

    def toml(asked: Any) -> dict[str, Any]:
        model, values = chosen(models, asked)
        return {"name": f"{Path(study.path).stem}-changed.toml", "text": model.toml(values)}

    return document(head), {"/solve": solve, "/toml": toml}


def _models(study: Study, run: int, highline: SceneHighline | None) -> list[Model]:
    own = elastic_model(study, run)
    return [own] if highline is None else [*stage_models(highline.numbers), own]
