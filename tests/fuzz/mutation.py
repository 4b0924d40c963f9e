"""Deterministic mutations of a valid input: bytes, and the words that formats trip over."""

import random
import struct

WORDS = [
    b"", b"nan", b"inf", b"-1", b"0", b"1e999", b"-0.0", b"1e-320", b"9" * 400, b"true", b"null",
    b"~", b"[]", b"{}", b"[" * 400, b"{a: " * 200, b"&a [*a]", b"!!python/object/apply:os.abort []",
    b"!!binary aGk=", b"2001-01-01", b"0x1F", b"1_000", b"\x00", b"\xff\xfe", "\u2028é\U0001f980".encode(),
    b"'", b'"', b"\r", b"\n\n", b"\t", b",", b";", b":", b"- ", b"#", b"../../etc/passwd", b"/", b"a" * 5000,
    b"x: &x [y, y, y, y, y, y, y, y]\nz: &z [*x, *x, *x, *x, *x, *x, *x, *x]\n",
    b"\n<<: {a: 1}\n", b"? [1]\n: 2\n",
]  # fmt: skip
BOMB = b"\n".join(
    [b"b0: &b0 [lol, lol, lol, lol, lol, lol, lol, lol, lol]"]
    + [b"b%d: &b%d [%s]" % (i, i, b", ".join([b"*b%d" % (i - 1)] * 9)) for i in range(1, 11)]
)
WORDS.append(b"\n" + BOMB + b"\n")
INTEGERS = [
    0,
    1,
    127,
    128,
    255,
    2**15,
    2**16 - 1,
    2**31 - 1,
    2**31,
    2**32 - 1,
    2**63 - 1,
    2**64 - 1,
]


def mutated(data: bytes, seed: int) -> bytes:
    """One to six mutations of ``data``."""
    rng = random.Random(seed)
    changed = bytearray(data)
    for _ in range(rng.choice([1, 1, 1, 2, 3, 6])):
        rng.choice(MUTATIONS)(changed, rng)
    return bytes(changed)


def _flip(data, rng):
    if data:
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def _set(data, rng):
    if data:
        data[rng.randrange(len(data))] = rng.choice([0, 255, 32, 45, 48, 127])


def _cut(data, rng):
    del data[rng.randrange(len(data) + 1) :]


def _remove(data, rng):
    first = rng.randrange(len(data) + 1)
    del data[first : first + rng.choice([1, 2, 8, 64, 1024])]


def _repeat(data, rng):
    first = rng.randrange(len(data) + 1)
    data[first:first] = data[first : first + rng.choice([1, 4, 64, 4096])]


def _word(data, rng):
    first = rng.randrange(len(data) + 1)
    data[first : first + rng.choice([0, 1, 4])] = rng.choice(WORDS)


def _integer(data, rng):
    size, code = rng.choice([(1, "B"), (2, "H"), (4, "I"), (8, "Q")])
    if len(data) > size:
        first = rng.randrange(len(data) - size)
        value = rng.choice(INTEGERS) & (256**size - 1)
        data[first : first + size] = struct.pack(rng.choice("<>") + code, value)


def _token(data, rng):
    """Replace what stands between two separators, as of a cell or a YAML value."""
    separators = b",:\n[]{} "
    places = [i for i, byte in enumerate(data[:20000]) if byte in separators]
    if len(places) > 1:
        i = rng.randrange(len(places) - 1)
        data[places[i] + 1 : places[i + 1]] = rng.choice([b"", b" "]) + rng.choice(WORDS)


def _swap(data, rng):
    lines = bytes(data).split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[i], lines[j] = lines[j], lines[i]
    data[:] = b"\n".join(lines)


MUTATIONS = [_flip, _set, _cut, _remove, _repeat, _word, _integer, _token, _swap]
