"""Split Markdown into sentences and count their words; find house words.

The rule, used by ``docs_check.py`` and its tests:

* A word is a run of characters between white space with at least one letter or digit. A hyphenated word, a number and
  a URL are one word each. Inline code is one word, whatever it contains. A link's text counts, its target does not.
* A sentence ends with ``.``, ``!`` or ``?`` before white space, and at the end of its block. Colons, semicolons and
  dashes end nothing. Abbreviations (``e.g.``, ``i.e.``, ``cf.``, ``et al.`` and the like) and initials (``J. Doe``) end
  nothing; ``etc.`` ends a sentence before a capital letter.
* Blocks are paragraphs, list items, quotations, headings and cells of tables. A code block is one word of the sentence
  that it interrupts: the paragraph before it ends without a full stop and the one after it starts in lower case. It
  counts for nothing elsewhere.
* The mean of a page is that of its running text: paragraphs, list items and quotations. Headings and cells are short by
  nature and would flatter it, so they count for the longest sentence only.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

ABBREVIATIONS = {"e.g.", "i.e.", "cf.", "vs.", "al.", "fig.", "figs.", "eq.", "eqs.", "sec.", "approx.", "resp.", "ca."}
HOUSE_WORDS = {
    r"foretell\w*|foretold": "predict; callback; prefetched mask",
    r"has to be told": "callback; is reported",
    r"practi[sc]e (?:of )?(?:missed|goals)|practi[sc]es? goals": "failed-goal replay",
    r"limits? (?:for|of) advantages": "advantage clipping",
    r"horizon widens|widening (?:of the )?horizon": "discount schedule",
    r"pull of the mean action|pull towards the mean": "mean-action regularisation",
    r"policy average": "exponential moving average (EMA) of the weights",
    r"in pieces|of pieces": "micro-batches",
    r"seams?": "physics backend interface",
    r"mends?|mended|mending": "repairs; auto-reset of failed environments",
    r"rehears\w+": "sandboxed import",
    r"anew": "again",
    r"of late": "recently",
    r"told of": "reported",
    r"whatever ends it": "if it is interrupted",
    r"of now|(?:task|tasks)'s? own": "current; default",
    r"the study (?:finds|found|reports|says|has|names)": "the paper, by author and title at first mention",
    r"rooms?|front doors?|the houses?|household": "no metaphors: name the thing",
    r"learns of it|knows nothing of|knows none of": "is reported; does not use",
}
"""Pattern of a private word or metaphor -> the field's word for it."""

_HOUSE = re.compile("|".join(f"(\\b(?:{pattern})\\b)" for pattern in HOUSE_WORDS), re.IGNORECASE)
_ITEM = re.compile(r"^( {0,3})([-*+]|\d+[.)])( +)")
_FENCE = re.compile(r"^\s*(```+|~~~+)")
_ADMONITION = re.compile(r"^(?:!!!|\?\?\?\+?|===\+?)\s+(.*)$")
_DELIMITER = re.compile(r"^\s*\|?\s*:?-+:?\s*(\|\s*:?-+:?\s*)*\|?\s*$")
_END = re.compile(r"[.!?]+[\"')\]*_]*(?=[ \t\n])")


@dataclass
class Block:
    """A piece of a page: ``kind`` is text, heading, cell or code; ``line`` is that of its first character."""

    kind: str
    line: int
    text: str


@dataclass
class Sentence:
    """A sentence, its kind of block, the line where it starts, its number of words and its file."""

    kind: str
    line: int
    text: str
    words: int
    file: str = ""


def sentences_of(markdown: str) -> list[Sentence]:
    """Return the sentences of a page in order."""
    return [sentence for block in _joined(blocks_of(markdown)) for sentence in _split(block)]


def house_words(markdown: str) -> list[tuple[int, str, str]]:
    """Return line, word and the field's word for it, for each house word outside of code."""
    found = []
    for block in blocks_of(markdown):
        if block.kind != "code":
            text = re.sub(r"`[^`]*`", lambda code: "`" * len(code[0]), block.text)
            for match in _HOUSE.finditer(re.sub(r"\]\([^)]*\)", lambda link: "]" + " " * (len(link[0]) - 1), text)):
                better = list(HOUSE_WORDS.values())[(match.lastindex or 1) - 1]
                found.append((block.line + text[: match.start()].count("\n"), match[0], better))
    return found


def blocks_of(markdown: str) -> list[Block]:
    """Return the blocks of a page."""
    markdown = re.sub(r"<!--.*?-->", lambda comment: "\n" * comment[0].count("\n"), markdown, flags=re.DOTALL)
    lines = markdown.split("\n")
    if lines[0] == "---" and "---" in lines[1:]:
        end = lines.index("---", 1)
        lines[: end + 1] = [""] * (end + 1)
    return list(_parse(lines, 1))


def _parse(lines: list[str], first: int) -> Iterator[Block]:
    """Yield the blocks of lines, the first of which has this number."""
    i = 0
    while i < len(lines):
        line, number = lines[i], first + i
        if not line.strip():
            i += 1
        elif fence := _FENCE.match(line):
            end = next((j for j in range(i + 1, len(lines)) if lines[j].strip().startswith(fence[1])), len(lines) - 1)
            yield Block("code", number, "\n".join(lines[i : end + 1]))
            i = end + 1
        elif line.startswith("    "):
            end = _indented(lines, i)
            yield Block("code", number, "\n".join(lines[i:end]))
            i = end
        elif line.startswith(":::"):
            i = _indented(lines, i + 1)
        elif found := _ADMONITION.match(line):
            title = re.search(r'"(.+)"', found[1])
            if title:
                yield Block("heading", number, title[1])
            end = _indented(lines, i + 1)
            yield from _parse([body[4:] for body in lines[i + 1 : end]], number + 1)
            i = end
        elif heading := re.match(r"^#{1,6}\s+(.*?)\s*#*$", line):
            yield Block("heading", number, heading[1])
            i += 1
        elif "|" in line and i + 1 < len(lines) and "|" in lines[i + 1] and _DELIMITER.match(lines[i + 1]):
            while i < len(lines) and "|" in lines[i]:
                if not _DELIMITER.match(lines[i]):
                    yield from (Block("cell", first + i, cell) for cell in _cells(lines[i]))
                i += 1
        elif re.match(r"^\s*([-*_]\s*){3,}$", line) or re.match(r"^\[[^\]]+\]:\s", line):
            i += 1
        elif line.startswith(">"):
            end = next((j for j in range(i, len(lines)) if not lines[j].startswith(">")), len(lines))
            yield from _parse([re.sub(r"^> ?", "", quoted) for quoted in lines[i:end]], number)
            i = end
        elif item := _ITEM.match(line):
            end = _item_end(lines, i)
            body = [line[item.end() :], *(_dedent(text, item.end()) for text in lines[i + 1 : end])]
            yield from _parse(body, number)
            i = end
        else:
            end = i + 1
            while end < len(lines) and lines[end].strip() and not _starts_a_block(lines[end]):
                end += 1
            yield Block("text", number, "\n".join(lines[i:end]))
            i = end


def _starts_a_block(line: str) -> bool:
    """Whether a line ends the paragraph above it."""
    return bool(_FENCE.match(line) or re.match(r"^(#{1,6} |:::|>| {0,3}[-*+] +\S)", line))


def _indented(lines: list[str], start: int) -> int:
    """Return the index after the indented lines from ``start``, without blank lines at their end."""
    end = start
    for j in range(start, len(lines)):
        if lines[j].startswith("    "):
            end = j + 1
        elif lines[j].strip():
            break
    return end


def _item_end(lines: list[str], start: int) -> int:
    """Return the index after a list item that starts at ``start``."""
    for j in range(start + 1, len(lines)):
        if _ITEM.match(lines[j]) and not lines[j].startswith("  "):
            return j
        if not lines[j].strip():
            following = next((text for text in lines[j:] if text.strip()), "")
            if not following.startswith("  "):
                return j
        elif not lines[j].startswith(" ") and (not lines[j - 1].strip() or _starts_a_block(lines[j])):
            return j
    return len(lines)


def _dedent(line: str, offset: int) -> str:
    """Take the indent of a list item's text from a line."""
    indent = len(line) - len(line.lstrip(" "))
    return line[min(indent, 4 if indent >= 4 else offset) :]


def _cells(row: str) -> list[str]:
    """Return the cells of a table's row; bars in code and after a backslash belong to the cell."""
    row = re.sub(r"`[^`]*`", lambda code: code[0].replace("|", "\0"), row.strip())
    return [cell.strip().replace("\0", "|") for cell in re.split(r"(?<!\\)\|", row.strip("|")) if cell.strip()]


def _joined(blocks: list[Block]) -> Iterator[Block]:
    """Join the parts of sentences that code blocks interrupt; drop the other code blocks."""
    i = 0
    while i < len(blocks):
        block = blocks[i]
        i += 1
        if block.kind == "code":
            continue
        while (
            block.kind == "text"
            and i + 1 < len(blocks)
            and (blocks[i].kind, blocks[i + 1].kind) == ("code", "text")
            and not re.search(r"[.!?][\"')\]*]*$", block.text)
            and blocks[i + 1].text[0].islower()
        ):
            gap = [blocks[i].line - block.line - block.text.count("\n"), blocks[i + 1].line - blocks[i].line]
            block = Block(
                "text", block.line, block.text + "\n" * gap[0] + "`code`" + "\n" * gap[1] + blocks[i + 1].text
            )
            i += 2
        yield block


def _split(block: Block) -> Iterator[Sentence]:
    """Yield the sentences of a block."""
    text, start = _plain(block.text) + "\n", 0
    for end in [*(found for found in _END.finditer(text) if _ends(text, found)), None]:
        stop = len(text) if end is None else end.end()
        part = text[start:stop]
        words = sum(any(map(str.isalnum, word)) for word in re.split(r"[ \t\n]+", part))
        if words:
            lead = len(part) - len(part.lstrip())
            line = block.line + text[: start + lead].count("\n")
            yield Sentence(block.kind, line, " ".join(part.split()), words)
        start = stop


def _ends(text: str, found: re.Match[str]) -> bool:
    """Whether a full stop, exclamation or question mark ends a sentence."""
    before = re.split(r"[ \t\n(]", text[: found.end()])[-1]
    following = text[found.end() :].lstrip()
    lower = following[:1].islower()
    if before.lower() in ABBREVIATIONS or re.fullmatch(r"[A-Z]\.", before):
        return not following
    if before == "etc." or found[0].startswith("..") or found[0][-1] in ")]\"'":
        return not lower
    return True


def _plain(text: str) -> str:
    """Take the markup from a block's text; code keeps no white space, lines stay lines."""
    codes: list[str] = []

    def hide(code: re.Match[str]) -> str:
        codes.append(re.sub(r"\s", "\u00a0", code[0]))
        return f"\x00{len(codes) - 1}\x01" + "\n" * code[0].count("\n")

    text = re.sub(r"(`+)(.+?)\1", hide, text, flags=re.DOTALL)
    for _ in range(2):  # an image in a link
        text = re.sub(r"!?\[([^\[\]]*)\](?:\([^()\s]*(?:\([^()]*\))?[^()]*\)|\[[^\]]*\])", r"\1", text)
    text = re.sub(r"<(https?:[^>\s]+)>", r"\1", text)
    text = re.sub(r"</?[a-zA-Z][^>]*>", " ", text)
    text = re.sub(r"\{ ?[:#.][^}]*\}", "", text)
    return re.sub(r"\x00(\d+)\x01", lambda number: codes[int(number[1])], text)
