"""What is said about what cannot be used: one line, user's values cut, this program's own words in full."""

import pickle

import pytest

from rollbench.compare.errors import InputError, SceneNotCoveredError, one_line

REASON = "no room " + "for a long reason with numbers, " * 20 + "deepen the groove"


def test_values_of_users_are_cut():
    text = str(InputError("a.toml", "balls.radius", "x" * 500, "a length", "write one"))
    assert ("x" * 117 + "..." in text, "x" * 118 in text) == (True, False)
    assert one_line("a\tb\x1b[31m") == "a\\tb\\x1b[31m", "control characters are escaped"


def test_a_refusal_tells_cause_and_remedy_in_full_on_one_line():
    text = str(SceneNotCoveredError("my\nscene", "3D reference", REASON + ":\nwider;  ", "change it"))
    assert text.startswith("my\\nscene: 3D reference: no room ")
    assert text.endswith("deepen the groove: wider; advice: change it")
    assert all(words not in text for words in ("\n", "..."))


@pytest.mark.parametrize("error", [InputError("a", "b", "c", "d", "e", 3), SceneNotCoveredError("a", "b", REASON, "e")])
def test_errors_travel_between_processes(error):
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back)) == (type(error), str(error))
