"""Check the pages of the documentation: sentence lengths, house words and links.

    python scripts/maintainers/docs_check.py                   # every page, one line each
    python scripts/maintainers/docs_check.py docs/usd.md       # some pages, with their worst sentences
    python scripts/maintainers/docs_check.py --worst 20        # the longest sentences of all pages
    python scripts/maintainers/docs_check.py --docstrings      # the public docstrings, one line for each package

A page passes if the mean length of its sentences is under 18 words, none is over 35 words, it has no house word, and
each of its links leads to a file and heading that exist. :mod:`docs_prose` states how sentences and words are counted.
Laboratory notes (``docs/notes/``) and the change log are exempt from the goals, not from the check of links. The public
docstrings of a package have the same goals, and a first line does not begin with "What", "How", "Of" and the like. The
exit status is 1 if a page or package fails.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from docs_links import broken_links
from docs_pages import PAGES
from docs_prose import Sentence, house_words, sentences_of
from docs_strings import docstrings

ROOT = Path(__file__).resolve().parents[2]
MEAN, LONGEST = 18, 35
"""The mean number of words per sentence has to be under the first, the longest at most the second."""
GENERATED = frozenset(["api/index.md", *(page.file for group in PAGES.values() for page in group)])
"""Pages of the reference, which the site's build makes."""
EXEMPT = ("docs/notes/", "CHANGELOG.md")
"""Pages without goals: beginnings of their paths."""


@dataclass
class Page:
    """The figures of a page and what is wrong with it."""

    name: str
    sentences: list[Sentence]
    wrong: list[str] = field(default_factory=list)
    """What fails the goals, as ``file:line: reason``."""
    broken: list[str] = field(default_factory=list)
    """Links that lead nowhere, as ``file:line: reason``."""

    @property
    def mean(self) -> float:
        """Mean number of words per sentence of running text; 0 without one."""
        words = [sentence.words for sentence in self.sentences if sentence.kind == "text"]
        return sum(words) / len(words) if words else 0.0

    @property
    def longest(self) -> int:
        """Number of words of the longest sentence."""
        return max((sentence.words for sentence in self.sentences), default=0)

    @property
    def state(self) -> str:
        """One word for the table."""
        if self.broken:
            return "broken links"
        if self.name.startswith(EXEMPT):
            return "exempt"
        return "FAILS" if self.wrong else "ok"

    @property
    def fails(self) -> bool:
        """Whether the page makes the check fail."""
        return self.state in ("broken links", "FAILS")


def pages() -> list[str]:
    """Return the pages there are, relative to the repository."""
    files = [*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md")]
    return sorted(str(path.relative_to(ROOT)) for path in files)


def check(name: str) -> Page:
    """Check one page.

    Args:
        name: Path relative to the repository.

    Returns:
        The page with its sentences and what is wrong with it.
    """
    text = (ROOT / name).read_text()
    page = Page(name, [replace(sentence, file=name) for sentence in sentences_of(text)])
    page.wrong += _over_the_goals(page)
    for line, word, better in house_words(text):
        page.wrong.append(f'{name}:{line}: house word "{word}": {better}')
    for line, target, reason in broken_links(ROOT / name, GENERATED):
        page.broken.append(f"{name}:{line}: link to {target}: {reason}")
    return page


def check_docstrings(source: Path = ROOT / "source") -> list[Page]:
    """Check the public docstrings.

    Args:
        source: Folder of the packages.

    Returns:
        A :class:`Page` for each package: of a large one, for each package or module in it.
    """
    packages: dict[str, Page] = {}
    for text in docstrings(source):
        file = str(text.file.relative_to(source.parent))
        name = ".".join(text.module.split(".")[:2])
        page = packages.setdefault(name, Page(name, []))
        page.sentences += [replace(sentence, file=file) for sentence in text.sentences]
        page.wrong += [f"{file}:{line}: {reason}" for line, reason in text.wrong]
    for page in packages.values():
        page.wrong += _over_the_goals(page)
    return list(packages.values())


def _over_the_goals(page: Page) -> list[str]:
    """Return the mean and the sentences that are over the goals."""
    wrong = [f"{s.file}:{s.line}: {s.words} words: {s.text}" for s in page.sentences if s.words > LONGEST]
    if page.mean >= MEAN:
        wrong.insert(0, f"{page.name}: {page.mean:.1f} words per sentence; the goal is under {MEAN}")
    return wrong


def main() -> int:
    """Print a line for each page or package and what fails; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("pages", nargs="*", help="Pages to check, with --docstrings packages (default: all).")
    parser.add_argument("--docstrings", action="store_true", help="Check the public docstrings instead of pages.")
    parser.add_argument("--worst", type=int, metavar="N", help="Number of longest sentences to print.")
    args = parser.parse_args()
    if args.docstrings:
        known = {page.name: page for page in check_docstrings()}
        named = args.pages
    else:
        known = dict.fromkeys(pages())
        named = [str(Path(page).resolve().relative_to(ROOT)) for page in args.pages]
    if missing := sorted(set(named) - set(known)):
        parser.error(f"nothing is called {', '.join(missing)}; choose from {', '.join(known)}")
    found = [known[name] or check(name) for name in named or known]
    print(f"{'page':<42}{'sentences':>10}{'mean':>7}{'longest':>9}  state")
    for page in found:
        print(f"{page.name:<42}{len(page.sentences):>10}{page.mean:>7.1f}{page.longest:>9}  {page.state}")
    for page in found:
        print(*page.broken, sep="\n", end="\n" if page.broken else "")
        if page.wrong and (page.fails or named):
            print(*page.wrong, sep="\n")
    ranked = sorted((sentence for page in found for sentence in page.sentences), key=lambda s: -s.words)
    for s in ranked[: args.worst if args.worst is not None else 10 if named else 0]:
        print(f"{s.file}:{s.line}: {s.words} words: {s.text}")
    return int(any(page.fails for page in found))


if __name__ == "__main__":
    sys.exit(main())
