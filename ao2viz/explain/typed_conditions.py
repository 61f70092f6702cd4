"""Conditions on the steps of an episode, as people type them: "margin < 0.1 and not explored".

A parser of its own: nothing that is typed is ever run. The grammar, in which a name is a feature
of the task, one of `QUANTITIES`, or the name of an action:

    condition  = conjunction ("or" conjunction)*
    conjunction = negation ("and" negation)*
    negation   = "not" negation | "(" condition ")" | comparison | flag
    comparison = quantity ("<" | "<=" | ">" | ">=" | "=" | "!=") number [unit]
               | "action" ("=" | "!=") action
    flag       = "explored" | "new option" | "tie" | "close call" | "reward drop" | "never seen"
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.conditions import (
    FLAGS,
    QUANTITIES,
    AllOf,
    AnyOf,
    Compare,
    Condition,
    Flag,
    IsAction,
    Not,
)

_WORDS = ("and", "or", "not", "action", *QUANTITIES, *FLAGS)
_OPERATOR = re.compile(r"<=|>=|==|!=|<|>|=|≤|≥|≠")
_PLAIN = {"==": "=", "≤": "<=", "≥": ">=", "≠": "!="}
_INNER = r"\w+\-−.,'/"  # What names consist of beside spaces: one must not end in the middle.
_GOES_ON = re.compile(rf"[{_INNER}]")
_NUMBER = re.compile(r"[+\-−]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[+\-]?[0-9]+)?", re.IGNORECASE)
_UNIT = re.compile(r"[^\s()<>=!]+")
_LONGEST = 1_000  # Characters.
_MOST_NAMES = 300  # Actions or features that are known by name.
_DEEPEST = 40  # Brackets and "not" inside one another.


class ConditionError(ValueError):
    """What was typed is no condition; says where, what was expected, and what came."""

    def __init__(self, text: str, at: int, expected: str) -> None:
        came = text[at : at + 20].strip()
        what = f"“{came}”" if came else "the end"
        super().__init__(f"At character {at + 1}: expected {expected}, but there is {what}.")
        self.at = at


def parse_condition(text: str, spec: TaskSpec) -> Condition:
    """Reads a condition; what `str` makes of one reads as the same one.

    Letters may be small or capital. A name may be shortened to its last words where that names
    one thing only ("left" for "push left"); an action or a feature may be given by its number.

    Raises:
        ConditionError: If it is none.
    """
    return _Parser(text, spec).parse()


@dataclass(frozen=True)
class _Name:
    """A way to write something, the thing it stands for, and how it is written in full."""

    written: str
    meaning: int | str
    shown: str


class _Parser:
    """Recursive descent over the text itself, because names consist of several words."""

    def __init__(self, text: str, spec: TaskSpec) -> None:
        self._text, self._spec = text, spec
        self._at = self._deep = 0
        features = [feature.name for feature in spec.features]
        self._quantities = [
            *(_Name(name, name, name) for name in QUANTITIES),
            *_names_of(features, "feature", _WORDS),
        ]
        self._actions = _names_of(spec.action_names, "action", ("and", "or", "not"))
        self._flags = [_Name(name, name, name) for name in FLAGS]

    def parse(self) -> Condition:
        if len(self._text) > _LONGEST:
            raise ConditionError(self._text, _LONGEST, f"at most {_LONGEST:,} characters")
        condition = self._any_of()
        self._skip()
        if self._at < len(self._text):
            raise self._error("“and”, “or” or the end")
        return condition

    def _any_of(self) -> Condition:
        parts = [self._all_of()]
        while self._takes_word("or"):
            parts.append(self._all_of())
        return parts[0] if len(parts) == 1 else AnyOf(tuple(parts))

    def _all_of(self) -> Condition:
        parts = [self._negation()]
        while self._takes_word("and"):
            parts.append(self._negation())
        return parts[0] if len(parts) == 1 else AllOf(tuple(parts))

    def _negation(self) -> Condition:
        self._deep += 1
        if self._deep > _DEEPEST:
            raise self._error(f"at most {_DEEPEST} brackets and “not” inside one another")
        try:
            if self._takes_word("not"):
                return Not(self._negation())
            if self._takes("("):
                inner = self._any_of()
                if not self._takes(")"):
                    raise self._error("“)”, “and” or “or”")
                return inner
            return self._statement()
        finally:
            self._deep -= 1

    def _statement(self) -> Condition:
        # The longest name wins: "action" may be how a feature's name begins.
        choices = [*self._quantities, *self._flags, _Name("action", "action", "action")]
        name = self._take_name(choices, "feature", len(self._spec.features))
        if name is None:
            raise self._error(f"one of {self._listed()}")
        if name in self._flags:
            return Flag(str(name.meaning))
        if name.meaning == "action":
            return self._action()
        return self._comparison(name)

    def _action(self) -> Condition:
        at = self._skip()
        operator = self._take(_OPERATOR)
        operator = _PLAIN.get(operator, operator)
        if operator not in ("=", "!="):
            self._at = at
            raise self._error("“=” or “!=”")
        name = self._take_name(self._actions, "action", len(self._spec.action_names))
        if name is None:
            raise self._error(f"an action: {_shortened(self._spec.action_names)}")
        return IsAction(int(name.meaning), operator == "=", name.shown)

    def _comparison(self, name: _Name) -> Condition:
        operator = self._take(_OPERATOR)
        if not operator:
            raise self._error(f"“<”, “<=”, “>”, “>=”, “=” or “!=” after {name.shown}")
        at = self._skip()
        digits = self._take(_NUMBER)
        value = float(digits.replace("−", "-")) if digits else np.inf
        if not np.isfinite(value):
            self._at = at
            raise self._error("a number")
        known = str(name.meaning)
        feature = name.meaning if isinstance(name.meaning, int) else None
        unit = self._spec.features[feature].unit if feature is not None else ""
        self._take_unit(unit, name.shown)
        if feature is not None:
            known = f"feature {feature}"
        return Compare(known, _PLAIN.get(operator, operator), value, name.shown, unit)

    def _take_unit(self, unit: str, shown: str) -> None:
        """Takes the unit if it is there; a wrong one is an error, and no unit is right."""
        at = self._skip()
        spelt = re.escape(unit).replace(r"\ ", r"\s+").replace("°", "(?:°|degrees?|deg)")
        match = re.compile(rf"{spelt}(?![^\s()])", re.IGNORECASE).match(self._text, at)
        if unit and match:
            self._at = match.end()
            return
        word = _UNIT.match(self._text, at)
        if word and word[0].lower() not in ("and", "or"):
            wanted = f"{unit} or nothing" if unit else "“and”, “or” or the end"
            raise self._error(f"{wanted} after the number, for {shown}")

    def _take_name(self, names: Sequence[_Name], kind: str = "", count: int = 0) -> _Name | None:
        """The longest of the names that the text goes on with, or the number of one of so many."""
        at = self._skip()
        found = [(end, n) for n in names if (end := _end_of(n.written, self._text, at))]
        numbered = re.compile(rf"{kind}\s+([0-9]{{1,9}})(?![{_INNER}])", re.IGNORECASE)
        match = numbered.match(self._text, at) if kind else None
        if match and int(match[1]) < count:
            i = int(match[1])
            plain = f"{kind} {i}"
            shown = next((name.shown for name in names if name.meaning == i), plain)
            found.append((match.end(), _Name(plain, i, shown)))
        if not found:
            return None
        self._at, name = max(found, key=lambda match: match[0])
        return name

    def _takes_word(self, word: str) -> bool:
        return self._take_name([_Name(word, word, word)]) is not None

    def _takes(self, character: str) -> bool:
        if not self._text.startswith(character, self._skip()):
            return False
        self._at += 1
        return True

    def _take(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self._text, self._skip())
        if match is None:
            return ""
        self._at = match.end()
        return match[0]

    def _skip(self) -> int:
        while self._at < len(self._text) and self._text[self._at].isspace():
            self._at += 1
        return self._at

    def _error(self, expected: str) -> ConditionError:
        self._skip()
        return ConditionError(self._text, self._at, expected)

    def _listed(self) -> str:
        features = [feature.name for feature in self._spec.features]
        return f"{_shortened(features)}, {', '.join(QUANTITIES)}, action, {', '.join(FLAGS)}"


def _names_of(names: Sequence[str], kind: str, taken: Sequence[str]) -> list[_Name]:
    """Every way to write one of these but its number: its name, and its last words.

    What can be told from no other, or is a word of the grammar, is left to its number; and so are
    the names past the first few hundred, which would take long to compare.
    """
    found = []
    known = [tuple(name.lower().split()) for name in names]
    endings = Counter(words[n:] for words in known for n in range(len(words)))
    for i, words in enumerate(known[:_MOST_NAMES]):
        numbered, shown = f"{kind} {i}", f"{kind} {i}"
        for n in range(len(words)):
            ending = " ".join(names[i].split()[n:])
            is_clear = endings[words[n:]] == 1 or (n == 0 and known.count(words) == 1)
            if is_clear and ending.lower() not in taken and _can_stand(ending, numbered):
                shown = ending if n == 0 else shown
                found.append(_Name(ending, i, shown))
    return found


def _can_stand(name: str, numbered: str) -> bool:
    """Whether a name can be part of a condition without being read as something else."""
    if re.fullmatch(r"(feature|action) \d+", name, re.IGNORECASE):
        return name.lower() == numbered
    return re.fullmatch(rf"[+\-−]?\w(?:[{_INNER} ]*[{_INNER}])?", name) is not None and name.split(
        maxsplit=1
    )[0].lower() not in ("and", "or", "not")


def _end_of(name: str, text: str, at: int) -> int:
    """Where a name ends that stands at a place of the text; 0: it does not stand there.

    Any space is as good as another, either minus is a minus, and a plus in front may be left out.
    """
    for n, word in enumerate(name.split()):
        if n > 0:
            before = at
            while at < len(text) and text[at].isspace():
                at += 1
            if at == before:
                return 0
        is_bare = n == 0 and word.startswith("+") and not text.startswith("+", at)
        wanted = word[1:] if is_bare else word
        if _folded(text[at : at + len(wanted)]) != _folded(wanted):
            return 0
        at += len(wanted)
    return 0 if _GOES_ON.match(text, at) else at


def _folded(text: str) -> str:
    return text.lower().replace("−", "-")


def _shortened(names: Sequence[str], most: int = 8) -> str:
    more = ", …" if len(names) > most else ""
    return ", ".join(names[:most]) + more
