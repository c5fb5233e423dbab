"""Bad files made from good ones: tokens, lines, bytes, encodings and values are spoiled."""

import json
import re
from collections.abc import Sequence
from copy import deepcopy
from random import Random
from typing import Any

WORDS = (
    "nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e999", "9" * 400, "-1", "0", "-0.0",
    "2.5",
    "9007199254740993", "18446744073709551616", "99999999999", "1_000", "0x10", "\u0663", "1e5",
    "", "\x00", "Car", "DontCare", '"', "'", "[", "]", "{", "}", "[]", "{}", "=", "#", ",", ";",
    ":",
    "true", "false", "null", "None", "1979-05-27", "\ufeff", "\x85", "\u2028", "\x0c", "\x1c",
    '"x"',
    "../../../etc/passwd", "/etc/passwd", "..", "[1, 2]", "{a = 1}", '"""', "1,2", "%s", "\\", "-",
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2.5, 1e308, float("nan"), float("inf"), 10**30, -(2**63),
    2**53 + 1,
    "", "x", "0000", "../../etc/passwd", "/etc/passwd", "a\x00b", "nan", [], {}, [1], [[]],
    {"": None},
    {"a": {"b": []}}, "\ud800", 10**400,
)  # fmt: skip
ENCODINGS = ("utf-16", "utf-32", "latin-1", "utf-8-sig", "cp037")
TOKEN = re.compile(r"[^\s,=\[\]{}:\"]+")
MOST_CHANGES = 4
DEEP = 20_000  # brackets inside each other; beyond what any parser of Python follows


def spoiled_text(good: bytes, rng: Random) -> bytes:
    """A text file with a few tokens, lines or bytes changed."""
    text = good.decode()
    for _ in range(rng.randint(1, MOST_CHANGES)):
        text = rng.choice((_token, _token, _token, _line, _line, _letters))(text, rng)
    raw = text.encode("utf-8", errors="surrogatepass")
    if rng.random() < 0.15:
        raw = spoiled_bytes(raw, rng)
    if rng.random() < 0.03:
        raw = text.encode(rng.choice(ENCODINGS), errors="replace")
    return raw


def spoiled_json(good: bytes, rng: Random) -> bytes:
    """A JSON file with a few of its values, keys or letters changed."""
    if rng.random() < 0.2:
        return spoiled_text(good, rng)
    if rng.random() < 0.02:
        return b"[" * DEEP if rng.random() < 0.5 else b'{"a":' * DEEP
    tree = json.loads(good)
    for _ in range(rng.randint(1, MOST_CHANGES)):
        tree = _value(tree, rng)
    text = json.dumps(tree)
    if rng.random() < 0.1:  # a key twice
        text = text.replace("{", '{"format": 1, "format": 2, ', 1)
    return text.encode()


def spoiled_toml(good: bytes, rng: Random) -> bytes:
    """A TOML file with a few of its tokens, lines or bytes changed."""
    if rng.random() < 0.02:
        key = rng.choice((b"version", b"axes", b"fx"))
        return key + b" = " + rng.choice((b"[" * DEEP, b"{a = " * (DEEP // 10), b"9" * DEEP))
    return spoiled_text(good, rng)


def spoiled_bytes(good: bytes, rng: Random) -> bytes:
    """A file with a few of its bytes flipped, cut out, doubled or made up, or its end cut off."""
    raw = bytearray(good)
    for _ in range(rng.randint(1, MOST_CHANGES)):
        at = rng.randrange(len(raw) + 1)
        length = rng.choice((1, 1, 2, 4, 16, 64))
        kind = rng.randrange(6)
        if kind == 0 and at < len(raw):
            raw[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            raw[at : at + length] = b""
        elif kind == 2:
            raw[at:at] = rng.randbytes(length)
        elif kind == 3:
            raw[at : at + length] = rng.choice((b"\xff", b"\x00", b"\x7f")) * length
        elif kind == 4:
            raw[at:at] = raw[at : at + length] * rng.randint(1, 8)
        elif rng.random() < 0.3:
            del raw[at:]
    return bytes(raw)


def _token(text: str, rng: Random) -> str:
    """Another word in place of one, or between two."""
    tokens = list(TOKEN.finditer(text))
    if not tokens:
        return text + rng.choice(WORDS)
    chosen = rng.choice(tokens)
    word = rng.choice(WORDS) if rng.random() < 0.8 else rng.choice(tokens).group()
    start = chosen.start() if rng.random() < 0.9 else chosen.end()
    return text[:start] + word + text[chosen.end() :]


def _line(text: str, rng: Random) -> str:
    """Lines doubled, left out, swapped, joined, blank, or ended in another way."""
    lines = text.split("\n")
    at, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(8)
    if kind == 0:
        lines.insert(at, lines[other])
    elif kind == 1:
        del lines[at]
    elif kind == 2:
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == 3:
        lines[at] += rng.choice((" ", ",", "")) + lines[other]
    elif kind == 4:
        lines.insert(at, rng.choice(("", " ", "\t", "\x0c", "\u3000", "#", ",,,", "0", "\x1f")))
    elif kind == 5:
        return rng.choice(("\r", "\r\n", "\n\r", "\x0b", "\x85", "\u2029")).join(lines)
    elif kind == 6:
        return text[: rng.randrange(len(text) + 1)]
    else:
        lines = lines[:at] + [lines[at]] * rng.randint(2, 20) + lines[at:]
    return "\n".join(lines)


def _letters(text: str, rng: Random) -> str:
    """A letter more, or a few less."""
    at = rng.randrange(len(text) + 1)
    if rng.random() < 0.5:
        return text[:at] + rng.choice(WORDS) + text[at:]
    return text[:at] + text[at + rng.choice((1, 2, 5, 40)) :]


def _value(tree: Any, rng: Random) -> Any:
    """The tree with one of its values replaced, left out, renamed, or one more."""
    if rng.random() < 0.05:
        return deepcopy(rng.choice(VALUES))
    holders = [each for each in _nodes(tree) if each]
    if not holders:
        return deepcopy(rng.choice(VALUES))
    new = deepcopy(rng.choice(VALUES))
    holder = rng.choice(holders)
    key: Any = rng.choice(list(holder)) if isinstance(holder, dict) else rng.randrange(len(holder))
    kind = rng.random()
    if kind < 0.7:
        holder[key] = new
    elif kind < 0.8:
        del holder[key]
    elif isinstance(holder, dict):
        holder[str(rng.choice(VALUES))] = holder.pop(key) if kind < 0.9 else new
    else:
        holder.append(new)
    return tree


def _nodes(tree: Any) -> list[Any]:
    """All lists and objects inside."""
    if isinstance(tree, dict):
        return [tree, *(node for value in tree.values() for node in _nodes(value))]
    if isinstance(tree, list):
        return [tree, *(node for value in tree for node in _nodes(value))]
    return []


def spoiled_any(good: Sequence[bytes], rng: Random) -> bytes:
    """Bytes of one of the files, spoiled as bytes."""
    return spoiled_bytes(rng.choice(list(good)), rng)
