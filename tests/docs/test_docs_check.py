"""The check of the pages counts sentences, words and links as its rule says, and every page passes it."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts" / "maintainers"
sys.path.insert(0, str(SCRIPTS))

docs_check, docs_links, docs_prose = map(importlib.import_module, ("docs_check", "docs_links", "docs_prose"))


def counts(markdown, *kinds):
    return [s.words for s in docs_prose.sentences_of(markdown) if not kinds or s.kind in kinds]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("One two. Three four five! Six? Seven", [2, 3, 1, 1]),
        ("It is 2.5 m long, e.g. as J. Doe et al. wrote. Next one.", [12, 2]),
        ("A colon: here; and a semicolon - all one.", [8]),
        ("See [the long guide](a/very/long.md#target) and `a command --with spaces. Dots`.", [6]),
        ("Twice (really!) done. Fine.", [3, 1]),
        ("Screws, bolts, etc. Then more, etc. and on.", [3, 5]),
        ("Broken over\ntwo lines. And\nmore.", [4, 2]),
        ("state-of-the-art is 1 word", [4]),
        ("- first item\n- second\n  goes on\n\n  own paragraph\n\n1. third. Fourth", [2, 3, 2, 1, 1]),
        ("> quoted words. Here", [2, 1]),
        ("<p align='center'>Some <b>bold</b> text</p>", [3]),
        ('!!! note "A title"\n    Inner text here.\n\nOuter.', [2, 3, 1]),
        ("`a<b>c` stays one", [3]),
    ],
)
def test_sentences_and_words(text, words):
    assert counts(text) == words


def test_a_code_block_is_one_word_of_the_sentence_it_interrupts_and_nothing_elsewhere():
    assert counts("Here\n\n    python a.py --with many words\n\nprints two lines. Done.") == [5, 1]
    assert counts("Run this.\n\n```bash\npython a.py b c\n```\n\nThen that.") == [2, 2]
    assert counts("```python\nx = 1  # no words. At all\n```") == []


def test_cells_and_headings_are_texts_of_their_own_and_not_in_the_mean():
    page = "# A heading here\n\n| one | two words |\n|---|---|\n| `a | b` c | d. e f |\n\nRunning text of five words.\n"
    assert counts(page, "heading") == [3]
    assert counts(page, "cell") == [1, 2, 2, 1, 2]
    assert counts(page, "text") == [5]


def test_lines_of_sentences():
    page = "# Title\n\nOne `a b`.\nTwo\nends here. Three.\n\n- item\n\n        code\n\n| a |\n|---|\n| b |\n"
    lines = [(s.text, s.line) for s in docs_prose.sentences_of(page)]
    assert lines == [
        ("Title", 1),
        ("One `a b`.", 3),
        ("Two ends here.", 4),
        ("Three.", 5),
        ("item", 7),
        ("a", 11),
        ("b", 13),
    ]


def test_house_words_are_found_outside_of_code_and_targets():
    page = "The seam is\nentered anew.\n\nA `seam` and [link](seam.md).\n\n    seam\n"
    assert [(line, word) for line, word, _ in docs_prose.house_words(page)] == [(1, "seam"), (2, "anew")]


def test_broken_links_are_named(tmp_path):
    (tmp_path / "other.md").write_text("# Some `code`, and more\n\n## Twice\n\n## Twice\n\n## Own {#own-id}\n")
    (tmp_path / "page.md").write_text(
        "[fine](other.md#some-code-and-more) [fine](other.md#twice_1) [fine](other.md#own-id) [fine](#here)\n"
        "[web](https://example.org/x#y) `[code](nothing.md)`\n\n"
        "[bad](missing.md)\n\n![bad](missing.png)\n\n[bad](other.md#nowhere) [bad](#nor-here)\n\n## Here\n"
    )
    found = docs_links.broken_links(tmp_path / "page.md")
    assert [(line, target) for line, target, _ in found] == [
        (4, "missing.md"),
        (6, "missing.png"),
        (8, "other.md#nowhere"),
        (8, "#nor-here"),
    ]
    assert "own-id" in found[2][2]


def test_a_page_over_the_goals_fails(tmp_path, monkeypatch):
    monkeypatch.setattr(docs_check, "ROOT", tmp_path)
    (tmp_path / "docs").mkdir()
    page = tmp_path / "docs" / "page.md"
    page.write_text(f"# Fine\n\n{'word ' * 17}end.\n")  # 18 words
    assert docs_check.check("docs/page.md").state == "FAILS"
    page.write_text(f"# Fine\n\n{'word ' * 16}end.\n")
    assert docs_check.check("docs/page.md").state == "ok"
    page.write_text(f"| {'word ' * 36} |\n|---|\n")
    assert docs_check.check("docs/page.md").fails


def test_public_docstrings_are_found_and_judged(tmp_path):
    (tmp_path / "source" / "package").mkdir(parents=True)
    (tmp_path / "source" / "package" / "_private.py").write_text('"""What is private."""\n')
    (tmp_path / "source" / "package" / "module.py").write_text(
        '"""Names of things."""\n\nLIMIT = 3\n"""What is the limit."""\n_X = 1\n"""Of nothing."""\n\n\n'
        "class Thing:\n"
        '    """Of a thing, the name."""\n\n    size: float = 1.0\n    """Size in m."""\n\n'
        "    def turn(self, angle):\n"
        '        """Turn the thing anew.\n\n'
        "        Args:\n            angle: Angle in rad. It is\n                positive.\n            other: None.\n\n"
        "        Example::\n\n            thing.turn(1.0)  # code is not counted at all\n\n"
        '        See :class:`~package.module.Thing` and ``a b c``.\n        """\n\n'
        "    def _hidden(self):\n"
        '        """What nobody sees."""\n'
    )
    (page,) = docs_check.check_docstrings(tmp_path / "source")
    assert [(s.text, s.line) for s in page.sentences] == [
        ("Names of things.", 1),
        ("What is the limit.", 4),
        ("Of a thing, the name.", 10),
        ("Size in m.", 13),
        ("Turn the thing anew.", 16),
        ("angle: Angle in rad.", 19),
        ("It is positive.", 19),
        ("other: None.", 21),
        ("Example:", 23),
        ("See `package.module.Thing` and ``a b c``.", 27),
    ]
    assert [reason.split(":")[1] for reason in page.wrong] == ["4", "10", "16"]
    assert [word in reason for word, reason in zip(("What", "Of", "anew"), page.wrong, strict=True)] == [True] * 3


@pytest.mark.parametrize("name", docs_check.pages())
def test_every_page_meets_the_goals(name):
    page = docs_check.check(name)
    assert page.broken == []
    if not name.startswith(docs_check.EXEMPT):
        assert page.wrong == []


def test_public_docstrings_meet_the_goals():
    pages = docs_check.check_docstrings()
    assert len(pages) > 30
    assert [reason for page in pages for reason in page.wrong] == []


def test_the_command_prints_a_line_for_each_page_and_the_worst_sentences():
    command = [sys.executable, str(SCRIPTS / "docs_check.py"), "docs/index.md", "--worst", "2"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    _, row, first, second = done.stdout.splitlines()
    assert row.startswith("docs/index.md")
    longest = int(row.split()[3])
    assert f": {longest} words: " in first
    assert second.startswith("docs/index.md:")
    wrong = subprocess.run([*command[:2], "docs/nothing.md"], cwd=ROOT, capture_output=True, text=True)
    assert wrong.returncode == 2
    assert "nothing is called docs/nothing.md" in wrong.stderr
