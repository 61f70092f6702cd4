"""What leaves a page is hidden at once, and not removed while a change may be on its way."""

from ao2viz.ui.leaving import PATIENCE_S, Leaving


class Thing:
    def __init__(self, said: list[str], name: str) -> None:
        self._said, self._name = said, name

    def hide(self) -> None:
        self._said.append(f"hide {self._name}")

    def remove(self) -> None:
        self._said.append(f"remove {self._name}")


def test_what_leaves_is_hidden_at_once_and_removed_later_each_once():
    now, said = [10.0], []
    leaving = Leaving(lambda: now[0])
    leaving.add(Thing(said, "a"))
    now[0] += PATIENCE_S / 2
    leaving.add(Thing(said, "b"))
    leaving.tick()
    assert said == ["hide a", "hide b"]
    now[0] += PATIENCE_S / 2
    leaving.tick()
    assert said == ["hide a", "hide b", "remove a"]
    now[0] += PATIENCE_S
    leaving.tick()
    leaving.tick()
    assert said == ["hide a", "hide b", "remove a", "remove b"]
