"""Valid files with a few things wrong: bytes, tokens and lines.

Hypothesis draws which kinds of change are made and a seed; places and values follow from the seed,
so that a file of a megabyte costs a few draws.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence

from hypothesis import strategies as st

_NUMBERS = (0, 1, -1, 127, 255, 2**15, 2**16 - 1, 2**31 - 1, -(2**31), 2**32 - 1, 2**62, -(2**63))

_LARGEST_TEXT = 2 * 2**20  # three changes could make 300 x 300 x 300 lines of one

ODD_WORDS = (
    "", "nan", "inf", "-inf", "1e999", "-1e-999", "5e-324", "1e308", "-0.0", "9" * 400, "0x10",
    "1_000", "１２", "٣", "1,5", "1.234,5", "true", "null", "[]", "{}", "''", '""', '"', "'", "\\",
    "[", "]", "{", "}", "=", "#", ";", ",", ":", "\t", "\0", "\x1b[2J", "\ufeff", "\u202e",
    "\u2028", "\ud800", "Ω", "time", "time [s]", "../../etc/passwd", "/etc/passwd", "file:///etc/passwd",
    "%s%n", "${HOME}", "a" * 5000, "[" * 200, "\r", "\n", "\r\n", "1979-05-27T07:32:00Z",
)  # fmt: skip

_TOKEN = re.compile(r"\w+(?:\.\w+)*|\s+|[^\w\s]")


def byte_changes(corpus: Sequence[bytes]) -> st.SearchStrategy[bytes]:
    """Files of a corpus with up to eight changes of their bytes."""
    return st.builds(
        _changed_bytes,
        st.sampled_from(corpus),
        st.lists(st.sampled_from(sorted(_BYTE_CHANGES)), max_size=8),
        st.integers(0, 2**63),
        st.just(corpus),
    )


def text_changes(corpus: Sequence[bytes]) -> st.SearchStrategy[bytes]:
    """Texts of a corpus with up to eight changes of their tokens and lines."""
    texts = [content.decode("utf-8", "replace") for content in corpus]
    return st.builds(
        _changed_text,
        st.sampled_from(texts),
        st.lists(st.sampled_from(sorted(_TEXT_CHANGES)), max_size=8),
        st.integers(0, 2**63),
        st.just(texts),
    )


def _changed_bytes(content: bytes, kinds: list[str], seed: int, corpus: Sequence[bytes]) -> bytes:
    rng, changed = random.Random(seed), bytearray(content)
    for kind in kinds:
        if changed:
            _BYTE_CHANGES[kind](changed, rng, corpus)
    return bytes(changed)


def _changed_text(text: str, kinds: list[str], seed: int, corpus: Sequence[str]) -> bytes:
    rng = random.Random(seed)
    for kind in kinds:
        text = _TEXT_CHANGES[kind](text, rng, corpus)[:_LARGEST_TEXT]
    encoding = rng.choice(["utf-8"] * 20 + ["utf-16", "utf-8-sig", "cp1252", "utf-32"])
    return text.encode(encoding, "surrogatepass" if encoding.startswith("utf") else "replace")


def _slice(changed: bytearray, rng: random.Random) -> slice:
    begin = rng.randrange(len(changed))
    return slice(begin, begin + min(rng.choice([1, 2, 8, 64, 512]), len(changed) - begin))


def _flip(changed: bytearray, rng: random.Random, _: Sequence[bytes]) -> None:
    changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)


def _set(changed: bytearray, rng: random.Random, _: Sequence[bytes]) -> None:
    changed[rng.randrange(len(changed))] = rng.choice([0, 1, 127, 128, 255, rng.randrange(256)])


def _number(changed: bytearray, rng: random.Random, _: Sequence[bytes]) -> None:
    width = rng.choice([2, 4, 8])
    value = rng.choice(_NUMBERS) % (1 << 8 * width)
    begin = rng.randrange(len(changed))
    changed[begin : begin + width] = value.to_bytes(width, rng.choice(["little", "big"]))


def _early(changed: bytearray, rng: random.Random, _: Sequence[bytes]) -> None:
    """In the head, where formats keep their sizes."""
    begin = rng.randrange(min(len(changed), 600))
    changed[begin] = rng.choice([0, 1, 2, 127, 128, 255, rng.randrange(256)])


def _delete(changed: bytearray, rng: random.Random, _: Sequence[bytes]) -> None:
    del changed[_slice(changed, rng)]


def _repeat(changed: bytearray, rng: random.Random, _: Sequence[bytes]) -> None:
    part = _slice(changed, rng)
    changed[part.start : part.start] = changed[part] * rng.choice([1, 2, 50])


def _insert(changed: bytearray, rng: random.Random, _: Sequence[bytes]) -> None:
    begin = rng.randrange(len(changed) + 1)
    changed[begin:begin] = rng.randbytes(rng.choice([1, 4, 32]))


def _splice(changed: bytearray, rng: random.Random, corpus: Sequence[bytes]) -> None:
    other = bytearray(rng.choice(corpus))
    if other:
        changed[_slice(changed, rng)] = other[_slice(other, rng)]


def _cut(changed: bytearray, rng: random.Random, _: Sequence[bytes]) -> None:
    del changed[rng.randrange(len(changed)) :]


def _zero(changed: bytearray, rng: random.Random, _: Sequence[bytes]) -> None:
    part = _slice(changed, rng)
    changed[part] = bytes(part.stop - part.start)


_BYTE_CHANGES: dict[str, Callable[[bytearray, random.Random, Sequence[bytes]], None]] = {
    "cut": _cut, "delete": _delete, "early": _early, "flip": _flip, "insert": _insert,
    "number": _number, "repeat": _repeat, "set": _set, "splice": _splice, "zero": _zero,
}  # fmt: skip


_TextChange = Callable[[str, random.Random, Sequence[str]], str]
_PartsChange = Callable[[list[str], int, random.Random, Sequence[str]], None]


def _on_tokens(change: _PartsChange) -> _TextChange:
    def apply(text: str, rng: random.Random, corpus: Sequence[str]) -> str:
        tokens = _TOKEN.findall(text)
        if not tokens:
            return text
        change(tokens, rng.randrange(len(tokens)), rng, corpus)
        return "".join(tokens)

    return apply


def _on_lines(change: _PartsChange) -> _TextChange:
    def apply(text: str, rng: random.Random, corpus: Sequence[str]) -> str:
        lines = text.split("\n")
        change(lines, rng.randrange(len(lines)), rng, corpus)
        return "\n".join(lines)

    return apply


def _odd(parts: list[str], place: int, rng: random.Random, _: Sequence[str]) -> None:
    parts[place] = rng.choice(ODD_WORDS)


def _odd_number(parts: list[str], place: int, rng: random.Random, _: Sequence[str]) -> None:
    numbers = [k for k, part in enumerate(parts) if part[:1].isdigit()]
    parts[rng.choice(numbers) if numbers else place] = rng.choice(ODD_WORDS[:20])


def _remove(parts: list[str], place: int, rng: random.Random, _: Sequence[str]) -> None:
    del parts[place : place + rng.choice([1, 1, 1, 3, 20])]


def _double(parts: list[str], place: int, rng: random.Random, _: Sequence[str]) -> None:
    parts[place:place] = [parts[place]] * rng.choice([1, 1, 2, 300])


def _swap(parts: list[str], place: int, rng: random.Random, _: Sequence[str]) -> None:
    other = rng.randrange(len(parts))
    parts[place], parts[other] = parts[other], parts[place]


def _other_line(parts: list[str], place: int, rng: random.Random, corpus: Sequence[str]) -> None:
    parts[place] = rng.choice(rng.choice(corpus).split("\n"))


def _end(parts: list[str], place: int, _: random.Random, __: Sequence[str]) -> None:
    del parts[place:]


_TEXT_CHANGES: dict[str, _TextChange] = {
    "line double": _on_lines(_double), "line end": _on_lines(_end), "line odd": _on_lines(_odd),
    "line other": _on_lines(_other_line), "line remove": _on_lines(_remove),
    "line swap": _on_lines(_swap), "token double": _on_tokens(_double),
    "token number": _on_tokens(_odd_number), "token odd": _on_tokens(_odd),
    "token remove": _on_tokens(_remove), "token swap": _on_tokens(_swap),
}  # fmt: skip
