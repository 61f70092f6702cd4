"""An episode in three dimensions, on a page that plays without a server: viser's own recording."""

import contextlib
from typing import IO

import numpy as np
import viser
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import number
from ao2viz.exports.content import Content, Step
from ao2viz.exports.escaping import one_line, to_html
from ao2viz.figures.palette import EDGE, PATH, UNTRIED, action_colors
from ao2viz.figures.raster import shorten
from ao2viz.layout.cones import find_heights
from ao2viz.layout.discs import lay_out

_TITLE = "<title>Viser</title>"  # Of the page that viser writes.
_STEP_S = 0.25  # Shown for so long.
_DEEP = 0.5  # Heights of the cones, as a share of those on the canvas.
_NAME_WIDTH = 240  # Pixels for an action's name; a longer one would run off the page.
_SIZES = (0.5, 0.7, 0.9)  # Of points, by how often an option was visited.


def write_replay(content: Content, stream: IO[bytes]) -> None:
    """A page with the forest as cones, and the path of each step of the chosen episode in it.

    Points and lines are drawn flat, so that colours mean what they do everywhere else.
    """
    spec, view = content.spec, content.view
    numbered = content.chosen
    steps = len(numbered.episode)
    places = _place(view)
    # It listens on this machine only, on a port that nobody knows, until the page is written.
    with contextlib.redirect_stdout(None):  # It greets even if told not to.
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        scene = server.scene
        _draw_forest(scene, view, spec, places)
        _point_camera(server, places[view.is_alive])
        recording = server.get_scene_serializer()
        for step in content.steps(numbered):
            _draw_step(scene, step, steps, places, spec)
            recording.insert_sleep(_STEP_S)
            content.progress(0.95 * (step.number + 1) / steps)
        page = recording.as_html(dark_mode=True)
    finally:
        with contextlib.redirect_stdout(None):
            server.stop()
    title = f"{spec.title}, episode {numbered.number + 1}: an AO2 agent's decisions"
    stream.write(page.replace(_TITLE, f"<title>{to_html(title)}</title>", 1).encode())


def _place(view: ForestView) -> NDArray[np.float32]:
    """[N, 3] discs raised into cones; NaN once cleansed."""
    heights = _DEEP * find_heights(view.depths)
    return np.column_stack([lay_out(view).positions, heights]).astype(np.float32)


def _draw_forest(
    scene: viser.SceneApi, view: ForestView, spec: TaskSpec, places: NDArray[np.float32]
) -> None:
    scene.set_up_direction("+z")
    scene.world_axes.visible = False
    alive = np.flatnonzero(view.is_alive)
    children = alive[view.parents[alive] != NO_OPTION]
    if len(children):
        ends = np.stack([places[view.parents[children]], places[children]], axis=1)
        scene.add_line_segments("/edges", ends, EDGE, thickness=1.0, thickness_units="screen")
    visits = view.visits[alive].sum(axis=1)
    colors = action_colors(spec.n_actions, is_ordered=spec.action_grid is not None)
    chosen = np.where(
        visits[:, None] > 0, colors[view.best_actions[alive]], np.array(UNTRIED, np.uint8)
    ).astype(np.uint8)
    levels = np.digitize(visits, [4, 40])
    for level, size in enumerate(_SIZES):
        rows = np.flatnonzero(levels == level)
        if len(rows):
            _add_points(scene, f"/options/{level}", places[alive[rows]], chosen[rows], size)


def _draw_step(
    scene: viser.SceneApi,
    step: Step,
    steps: int,
    places: NDArray[np.float32],
    spec: TaskSpec,
) -> None:
    """Replaces the path that is shown, and what is said of it."""
    path = _known(step.decision, places)
    # A path of one option is a line from it to itself: there is always something to replace.
    shown = places[path] if len(path) else np.zeros((1, 3), np.float32)
    ends = np.stack([shown[:-1], shown[1:]], axis=1) if len(shown) > 1 else shown[[[0, 0]]]
    pink = np.tile(np.array(PATH, np.uint8), (len(shown), 1))
    scene.add_line_segments("/path/line", ends, PATH, thickness=5.0, thickness_units="screen")
    _add_points(scene, "/path/options", shown, pink, 1.1)
    decision = step.decision
    name = shorten(one_line(spec.action_names[decision.action]), 14, _NAME_WIDTH)
    told = (
        f"step {step.number} of {steps - 1}: {name}, "
        f"margin {number(decision.margin)}{'' if step.is_faithful else ', NOT as explained'}"
    )
    top = np.nanmax(places, axis=0) if len(places) else np.zeros(3)
    scene.add_label("/told", told, position=(0.0, float(top[1]), 6.0), anchor="bottom-center")
    if len(path):
        scene.add_label("/chosen", f"option {path[-1]}", position=shown[-1], anchor="bottom-left")


def _known(decision: Decision, places: NDArray[np.float32]) -> NDArray[np.int64]:
    """The options of the path that still are in the forest."""
    path = decision.path[decision.path < len(places)]
    return path[np.isfinite(places[path, 0])]


def _add_points(
    scene: viser.SceneApi,
    name: str,
    places: NDArray[np.float32],
    colors: NDArray[np.uint8],
    size: float,
) -> None:
    scene.add_point_cloud(
        name,
        places,
        colors,
        point_size=size,
        point_shape="circle",
        point_shading="flat",
        precision="float32",
    )


def _point_camera(server: viser.ViserServer, places: NDArray[np.float32]) -> None:
    """Looks at the whole forest from the front and above."""
    reach = float(np.abs(places[:, :2]).max()) + 5 if len(places) else 10.0
    server.initial_camera.look_at = (0.0, 0.0, 0.0)
    server.initial_camera.position = (0.0, -1.05 * reach, 0.95 * reach)
