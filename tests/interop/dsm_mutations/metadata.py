"""Changes of the metadata: keys and values of their JSON, and the text itself."""

import json
from pathlib import Path

ODD = [
    None, True, False, 0, 1, -1, 2, 3, 4, 8, 1.5, -0.0, 0.5, 1e-46, 1e-45, 1e39, 3.5e38, 0.99999999, 0.9999999,
    2**31 - 1, 2**31, -(2**31), -(2**31) - 1, 2**32 - 1, 2**32, 2**53 + 1, 2**63, 2**64 - 1, 2**64, 10**30,
    "", "deep", "planar", "box", "float", "\u0000", "ä€𐐷", "x" * 1000,
    [], {}, [0], [0, 0], [1, 2, 3], {"type": "int"},
]
# Numbers as texts that no Python value prints.
TEXTS = [
    "-0", "1.0", "1e0", "1E+2", "12e-1", "0.0", "1e400", "-1e400", "1e-400", "NaN", "Infinity", "01", "+1", ".5", "5.",
    "0x1", "1e", "--1", "1e999999999999", "0.99999997", "0.99999998", "0." + "9" * 60, "1" * 60, "[" * 200 + "]" * 200,
    "[" * 100 + "]" * 100, '"\\ud800"', '"\\ud83d\\ude00"', '"\\x"', '"\t"', "'a'", "1,", "/* */ 1", "tru", "nul",
    '{"a":1,"a":2}', '{"a":[{"b":1,"b":1}]}', "\u00a01", "[1,]", "{}", "[]", '""',
]


def _members():
    """By key the texts of members.txt."""
    members = {}
    for line in Path(__file__).with_name("members.txt").read_text().splitlines():
        if line.startswith("[") and line.endswith("]") and line[1:2].isalpha():
            texts = members.setdefault(line[1:-1], [])
        elif line and not line.startswith("#"):
            texts.append(line)
    members["folded"] = members["left_out"]
    return members


# Keys of the document that a map may lack, with values that are as they must be or nearly.
OPTIONAL = _members()


def text(chance, model):
    """Bytes of the text changed, put in or left out."""
    contents = bytearray(model.metadata)
    for _ in range(chance.randint(1, 2)):
        at = chance.randrange(len(contents))
        way = chance.randrange(4)
        if way == 0:
            contents[at] ^= 1 << chance.randrange(8)
        elif way == 1:
            del contents[at]
        elif way == 2:
            contents.insert(at, chance.choice(b' \t\n\r"0-1.eE,:[]{}\\u\x00\x80\xff\xc3x'))
        else:
            contents[at] = chance.choice(b'0123456789-.eE,:"[]{} ')
    model.metadata = bytes(contents)
    return model.write(), f"metadata {bytes(contents[:300])}"


def value(chance, model):
    """A value, anywhere in it, replaced, left out, twice, or under another name."""
    root = json.loads(model.metadata)
    parent, key = _anywhere(chance, root)
    way = chance.randrange(6)
    if way == 0:
        del parent[key]
        told = f"without {key!r}"
    elif way == 1 and isinstance(parent, dict):
        parent[chance.choice(("more", key + "x", key.upper(), "", "é"))] = parent.pop(key)
        told = f"{key!r} renamed"
    elif way in (2, 3):
        mark = "@mark@"
        parent[key] = mark
        odd = chance.choice(TEXTS)
        model.metadata = json.dumps(root).replace(f'"{mark}"', odd).encode()
        return model.write(), f"metadata {key!r}: {odd[:60]}"
    else:
        parent[key] = chance.choice(ODD)
        told = f"{key!r}: {str(parent[key])[:60]!r}"
    model.metadata = json.dumps(root, ensure_ascii=False).encode()
    return model.write(), f"metadata {told}"


def member(chance, model):
    """A key that maps may have, of this kind or another, with a value that is right or nearly, or one that is new."""
    root = json.loads(model.metadata)
    own = [key for key in OPTIONAL if key in root]
    key = chance.choice([*OPTIONAL, "more"] if chance.random() < 0.5 else own)
    odd = chance.choice(OPTIONAL.get(key, TEXTS))
    if chance.random() < 0.95:
        root.pop(key, None)
    body = json.dumps(root)
    model.metadata = (body[:-1] + f', "{key}": {odd}}}').encode()
    return model.write(), f"metadata {key!r}: {odd[:100]}"


def _anywhere(chance, root):
    places = []

    def walk(value):
        for key in value if isinstance(value, dict) else range(len(value)):
            places.append((value, key))
            if isinstance(value[key], (dict, list)):
                walk(value[key])

    walk(root)
    return chance.choice(places)
