"""Pictures drawn without a browser: sound SVG, and PNG that shows what it should."""

import itertools
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from ao2viz.figures import pictures
from ao2viz.figures.drawing import LIGHT, to_svg
from ao2viz.figures.palette import action_colors
from ao2viz.figures.pictures import draw_forest, draw_path
from ao2viz.figures.raster import text_width, to_image, wrap
from ao2viz.store.saved import SavedAgent
from tests.exports.agents import HOSTILE_ACTIONS, HOSTILE_TITLE, shipped
from tests.exports.conftest import Export
from tests.forests import no_options, random_view

SVG = "{http://www.w3.org/2000/svg}"
PATH_COLOR = (216, 27, 132)


def texts(root: ElementTree.Element) -> list[str]:
    return ["".join(node.itertext()) for node in root.iter(f"{SVG}text")]


def pixels(image: Image.Image, color: tuple[int, ...], slack: int = 30) -> int:
    """How many pixels have about this colour."""
    gaps = np.abs(np.asarray(image.convert("RGB")).astype(int) - np.array(color))
    return int((gaps.max(axis=2) <= slack).sum())


def test_svg_draws_every_living_option_once(cartpole: SavedAgent, write: Export) -> None:
    root = ElementTree.parse(write(cartpole, "svg")).getroot()
    legend = cartpole.spec.n_actions
    circles = len(list(root.iter(f"{SVG}circle")))
    assert circles == len(cartpole.forest_view()) + legend
    assert "Cart pole, 500 steps" in texts(root)


def test_a_step_adds_its_path_and_sentence(cartpole: SavedAgent, write: Export) -> None:
    plain = ElementTree.parse(write(cartpole, "svg")).getroot()
    decision = cartpole.episodes[1].decisions[7]
    shown = ElementTree.parse(write(cartpole, "svg", step=7, overwrite=True)).getroot()
    more = len(list(shown.iter(f"{SVG}circle"))) - len(list(plain.iter(f"{SVG}circle")))
    assert more == len(decision.path)
    assert str(decision.path[-1]) in texts(shown)
    assert any("Expected to earn" in text for text in texts(shown))


def test_the_ids_at_both_ends_of_a_path_stay_apart(cartpole: SavedAgent) -> None:
    for decision in cartpole.episodes[0].decisions:
        root = ElementTree.fromstring(
            to_svg(draw_forest(cartpole.forest_view(), cartpole.spec, decision)).encode()
        )
        ids = [node for node in root.iter(f"{SVG}text") if (node.text or "").isdigit()]
        assert [node.text for node in ids] == [
            str(i) for i in dict.fromkeys(decision.path[[0, -1]])
        ]
        spans = []
        for node in ids:
            wide = text_width(node.text or "", 15, is_bold=True)
            left = float(node.attrib["x"]) - (wide if node.attrib["text-anchor"] == "end" else 0)
            spans.append((left, left + wide))
        spans.sort()
        assert all(one[1] <= other[0] for one, other in itertools.pairwise(spans))


def test_png_shows_the_colours_of_the_actions_and_the_path(
    cartpole: SavedAgent, write: Export
) -> None:
    with Image.open(write(cartpole, "png")) as plain:
        assert plain.size[0] == 2400
        for color in action_colors(2, is_ordered=False):
            assert pixels(plain, tuple(color.tolist())) > 5_000
        assert pixels(plain, PATH_COLOR) == 0
    with Image.open(write(cartpole, "png", step=7, overwrite=True)) as shown:
        assert pixels(shown, PATH_COLOR) > 500


def test_the_path_is_a_stack_from_the_root_to_the_action(
    pendulum: SavedAgent, write: Export
) -> None:
    root = ElementTree.parse(write(pendulum, "path-svg", episode=0, step=3)).getroot()
    decision = pendulum.episodes[0].decisions[3]
    names = [text for text in texts(root) if text.startswith(("root ", "option "))]
    path = decision.path.tolist()
    assert names == [f"root {path[0]}", *(f"option {option}" for option in path[1:])]
    assert pendulum.spec.action_names[decision.action] in texts(root)
    with Image.open(write(pendulum, "path-png", episode=0, step=3)) as image:
        assert pixels(image, PATH_COLOR) > 200


@pytest.mark.parametrize("format", ["svg", "path-svg"])
def test_hostile_names_are_text(hostile: SavedAgent, write: Export, format: str) -> None:
    root = ElementTree.parse(write(hostile, format, step=2)).getroot()
    assert {node.tag for node in root.iter()} <= {
        f"{SVG}{tag}" for tag in ("svg", "title", "rect", "g", "circle", "path", "text")
    }
    assert not any(name.startswith("on") for node in root.iter() for name in node.attrib)
    said = " ".join(texts(root))
    assert (HOSTILE_TITLE if format == "svg" else "<script>") in said
    assert any(name[:20] in said for name in HOSTILE_ACTIONS)


def test_a_big_forest_is_thinned_but_keeps_the_path(
    cartpole: SavedAgent, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pictures, "MAX_DRAWN", 100)
    view = random_view(400, seed=3)
    rarest = int(np.argmin(view.visits.sum(axis=1)))
    field = pictures.ForestPicture(view, cartpole.spec, 500, np.array([rarest, 10**6]))
    assert rarest in field.drawn
    assert len(field.drawn) == 101
    assert field.caption == "the 101 options most visited of 400"


def test_an_empty_forest_and_a_decision_before_it_can_be_drawn(cartpole: SavedAgent) -> None:
    view = replace(
        cartpole.forest_view(), is_alive=np.zeros(len(cartpole.forest_view().parents), bool)
    )
    undecided = no_options()
    for drawing in (
        draw_forest(view, cartpole.spec, undecided),
        draw_path(undecided, cartpole.spec, view),
    ):
        assert "There were no options" in to_svg(drawing)
        assert to_image(drawing).width == drawing.width
    cleansed = draw_path(cartpole.episodes[0].decisions[0], cartpole.spec, view)
    assert "root 0" in to_svg(cleansed)
    assert " there, " not in to_svg(cleansed).split("Expected to earn")[0]


def test_a_long_path_loses_its_middle(cartpole: SavedAgent) -> None:
    decision = cartpole.episodes[0].decisions[0]
    path = np.arange(20)[None]
    long = replace(decision, paths=path, path_distances=np.ones((1, 20)))
    drawing = draw_path(long, cartpole.spec, cartpole.forest_view(), theme=LIGHT)
    svg = to_svg(drawing)
    assert "11 options between" in svg
    assert "option 19<" in svg
    assert "option 9<" not in svg


@given(st.text(max_size=80), st.integers(40, 400))
def test_wrapped_lines_fit_and_lose_nothing(text: str, width: int) -> None:
    lines = wrap(text, 14, width)
    assert "".join(lines).replace(" ", "") == "".join(text.split())
    assert all(text_width(line, 14) <= width or len(line) == 1 for line in lines)


def test_what_has_no_room_in_a_path_is_left_out_whole() -> None:
    agent = shipped("MountainCar-v0")
    said = [
        text
        for decision in agent.episodes[0].decisions
        for text in texts(
            ElementTree.fromstring(to_svg(draw_path(decision, agent.spec, agent.forest_view())))
        )
        if " now · " in text
    ]
    in_full = [text for text in said if text.endswith(" % of the distance")]
    assert 0 < len(in_full) < len(said)
    assert all(text.endswith(" %") for text in said if text not in in_full)
