"""Changes of the metadata: keys and values of their JSON, and the text itself."""

import json

ODD = [
    None, True, False, 0, 1, -1, 2, 3, 4, 8, 1.5, -0.0, 0.5, 1e-46, 1e-45, 1e39, 3.5e38, 0.99999999, 0.9999999,
    2**31 - 1, 2**31, -(2**31), -(2**31) - 1, 2**32 - 1, 2**32, 2**53 + 1, 2**63, 2**64 - 1, 2**64, 10**30,
    "", "deep", "planar", "box", "float", "\u0000", "ä€𐐷", "x" * 1000, [], {}, [0], [0, 0], [1, 2, 3], {"type": "int"},
]
# Numbers as texts that no Python value prints.
TEXTS = [
    "-0", "1.0", "1e0", "1E+2", "12e-1", "0.0", "1e400", "-1e400", "1e-400", "NaN", "Infinity", "01", "+1", ".5", "5.",
    "0x1", "1e", "--1", "1e999999999999", "0.99999997", "0.99999998", "0." + "9" * 60, "1" * 60, "[" * 200 + "]" * 200,
    "[" * 100 + "]" * 100, '"\\ud800"', '"\\ud83d\\ude00"', '"\\x"', '"\t"', "'a'", "1,", "/* */ 1", "tru", "nul",
    '{"a":1,"a":2}', '{"a":[{"b":1,"b":1}]}', "\u00a01", "[1,]", "{}", "[]", '""',
]
# Keys of this document that a map may lack, with values that are as they must be or nearly.
OPTIONAL = {
    "kind_version": ["1", "2", "0", "null", "1.0"],
    "compression": [
        "null", '{"method":"greedy"}', '{"method":"min-link","side":"lighter"}', '{"method":"new","side":"new"}', "{}",
        '{"method":1}', '{"side":"both"}', '{"method":null}', '{"method":"greedy","side":null}', '"greedy"',
        '{"method":"greedy","side":1}', '{"method":"greedy","more":[1]}', "[]", '{"method":"greedy","side":"nowhere"}',
    ],
    "camera": [
        "null", "{}", '{"world_to_camera":null,"world_to_ndc":null}', '{"world_to_camera":[1]}', "[]", "1",
        json.dumps({"world_to_camera": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}),
        json.dumps({"world_to_ndc": [0] * 16}), json.dumps({"world_to_ndc": [1e308] * 16}),
        '{"world_to_ndc":[' + ",".join(["1e400"] * 16) + "]}", '{"world_to_ndc":[' + ",".join(["null"] * 16) + "]}",
        json.dumps({"world_to_camera": [0] * 15}), json.dumps({"world_to_camera": [0] * 17}), '{"other":1}',
    ],
    "samples": ["null", "0", "1", "16", "4294967295", "4294967296", "18446744073709551615", "18446744073709551616", "1.5", "-1"],
    "filter": [
        "null", '{"shape":"box","width":1}', '{"shape":"box","width":0.99999999}', '{"shape":"box","width":0.5}',
        '{"shape":"tent","width":2}', '{"shape":"tent","width":1.5}', '{"shape":"tent","width":3}',
        '{"shape":"gaussian","width":1e38}', '{"shape":"gaussian","width":1e39}', '{"shape":"sinc","width":2}',
        '{"shape":"box"}', '{"width":1}', '{"shape":"box","width":1,"more":null}', "{}", '{"shape":"box","width":"1"}',
        '{"shape":"tent","width":1}', '{"shape":"tent","width":0.5}', '{"shape":"box","width":0}',
    ],
    "light": [
        "null", '{"shape":"point","size":[0,0]}', '{"shape":"point","size":[1,0]}', '{"shape":"disk","size":[1,1]}',
        '{"shape":"disk","size":[1,2]}', '{"shape":"sphere","size":[0,0]}', '{"shape":"rectangle","size":[0,3]}',
        '{"shape":"rectangle","size":[-0.0,1]}', '{"shape":"rectangle","size":[-1,1]}', '{"shape":"rectangle","size":[1e39,1]}',
        '{"shape":"rectangle","size":[1]}', '{"shape":"rectangle","size":[1,1,1]}', '{"shape":"tube","size":[1,1]}',
        '{"shape":"point"}', '{"size":[0,0]}', '{"shape":"rectangle","size":null}', '{"shape":"sphere","size":[2,1]}',
        '{"shape":"rectangle","size":[1e-46,1]}',
    ],
    "data_window": [
        "null", '{"min":[0,0],"max":[0,0]}', '{"min":[0,0],"max":[11,8]}', '{"min":[5,5],"max":[16,13]}',
        '{"min":[1,0],"max":[0,0]}', '{"min":[0],"max":[0,0]}', '{"min":[0,0]}', '{"min":[0,0],"max":[2147483648,0]}',
        '{"min":[-2147483648,-2147483648],"max":[2147483647,2147483647]}', '{"min":[0.0,0],"max":[1,1]}', "[0,0,1,1]",
        '{"min":[2147483640,0],"max":[2147483651,8]}', '{"min":[-5,-5],"max":[6,3]}',
    ],
    "display_window": [
        "null", '{"min":[0,0],"max":[0,0]}', '{"min":[1,0],"max":[0,0]}', '{"min":[-3,2],"max":[90,91]}',
        '{"min":[0,0,0],"max":[0,0,0]}', '{"min":[-2147483648,0],"max":[2147483647,0]}', "true", '{"min":[0,1],"max":[0,0]}',
    ],
    "software": ["null", '""', '"a"', "1", "[]", '"\\u0000"'],
    "attributes": [
        "{}", "null", "[]", '{"a":null}', '{"a":{}}', '{"a":{"type":"int","value":1}}', '{"a":{"type":"int","value":1.0}}',
        '{"a":{"type":"int","value":2147483648}}', '{"a":{"type":"int","hex":"01000000"}}', '{"a":{"type":"int","hex":"01"}}',
        '{"a":{"type":"int","hex":"1"}}', '{"a":{"type":"int","hex":"0G"}}', '{"a":{"type":"int","hex":"aAFf0000"}}',
        '{"a":{"type":"int","value":1,"hex":"01000000"}}', '{"a":{"type":"int"}}', '{"a":{"value":1}}', '{"a":{"hex":""}}',
        '{"a":{"type":"","hex":""}}', '{"":{"type":"x","hex":""}}', '{"a":{"type":"opaque","value":1}}',
        '{"a":{"type":"string","value":""}}', '{"a":{"type":"string","value":1}}', '{"a":{"type":"string","hex":"ff"}}',
        '{"a":{"type":"string","value":"\\u0000ä"}}', '{"a":{"type":"v2i","value":[1,2]}}', '{"a":{"type":"v2i","value":[1,2,3]}}',
        '{"a":{"type":"v2i","value":[1,null]}}', '{"a":{"type":"float","value":1e39}}', '{"a":{"type":"float","value":0.1}}',
        '{"a":{"type":"float","value":1e-50}}', '{"a":{"type":"float","value":-0.0}}', '{"a":{"type":"float","value":-0}}',
        '{"a":{"type":"float","value":16777217}}', '{"a":{"type":"float","value":[1]}}', '{"a":{"type":"float","hex":"0000c07f"}}',
        '{"a":{"type":"float","hex":"0000803f"}}', '{"a":{"type":"double","value":1e308}}', '{"a":{"type":"double","value":1e309}}',
        '{"a":{"type":"double","value":123456789012345678901234567890}}', '{"a":{"type":"double","value":"1"}}',
        '{"a":{"type":"m44f","value":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}}', '{"a":{"type":"m33d","value":[1,0,0,0,1,0,0,0,1]}}',
        '{"a":{"type":"m33f","value":[1,0,0,0,1,0,0,0]}}', '{"a":{"type":"chromaticities","value":[1,2,3,4,5,6,7,8]}}',
        '{"a":{"type":"box2i","value":[0,0,1,1]}}', '{"a":{"type":"box2f","value":[0,0,1,1.5]}}', '{"a":{"type":"box2i","hex":""}}',
        '{"a":{"type":"v3f","value":[3.5e38,0,0]}}', '{"a":{"type":"v3f","value":[3.4028235e38,0,0]}}',
        '{"a":{"type":"v3d","value":[1,2,3],"more":1}}', '{"a":{"type":1,"hex":""}}', '{"a":{"type":"int","hex":null}}',
        '{"a":{"type":"int","value":null}}', '{"a":{"type":"int","value":null,"hex":"00000000"}}',
        '{"a":{"type":"int","value":-0}}', '{"a":{"type":"v2i","value":[1e0,2]}}', '{"a":{"type":"int","value":1},"a":{"type":"int","value":1}}',
        '{"a":{"type":"compression","hex":"00"}}', '{"a":{"type":"chlist","hex":"00"}}', '{"a":{"type":"string","value":"a","hex":null}}',
    ],
    "left_out": [
        "null", '{"pixels":1,"max":0.5,"mean":0.25}', '{"pixels":0,"max":0,"mean":0}', '{"pixels":1,"max":0.25,"mean":0.5}',
        '{"pixels":1,"max":1.5,"mean":0.5}', '{"pixels":-1,"max":0.5,"mean":0.5}', '{"pixels":1000000,"max":0.5,"mean":0.5}',
        '{"pixels":1,"max":0.5}', '{"max":0.5,"mean":0.5}', '{"pixels":1,"max":-0.0,"mean":0}', "[]", '{"pixels":1.5,"max":1,"mean":1}',
        '{"pixels":18446744073709551615,"max":1,"mean":1}', '{"pixels":0,"max":0.5,"mean":0.25}', '{"pixels":1,"max":1,"mean":1e400}',
        '{"pixels":1,"max":1,"mean":1,"more":2}', '{"pixels":18446744073709551616,"max":1,"mean":1}', '{"pixels":1,"max":0,"mean":0}',
        '{"pixels":1,"max":0.5,"mean":0.5}', '{"pixels":1,"max":0.5,"mean":0}', '{"pixels":1,"max":1.00000001,"mean":0.5}',
    ],
    "coverage": ["1", "3", "8", "0", "16", "null", "8.0"],
    "media": ["null", '{"max_slabs":1}', '{"max_slabs":0}', "{}", '{"max_slabs":4294967295}', '{"max_slabs":4294967296}', '{"max_slabs":null}'],
    "layering": [
        "null", "{}", '{"resets":0,"max_layers":5,"light_depth":0}', '{"resets":0,"max_layers":0,"light_depth":0}',
        '{"resets":4294967295,"max_layers":4294967295,"light_depth":0}', '{"resets":0,"max_layers":4294967296,"light_depth":0}',
        '{"resets":0,"max_layers":9,"light_depth":-0.0}', '{"resets":0,"max_layers":9,"light_depth":1e39}', '{"resets":0,"max_layers":9}',
        '{"max_layers":9,"light_depth":0}', '{"resets":1,"max_layers":9,"light_depth":0}', '{"resets":0,"max_layers":9,"light_depth":-1}',
        '{"resets":0,"max_layers":9,"light_depth":null}', '{"resets":0,"max_layers":9,"light_depth":1,"more":0}', '{"resets":0,"light_depth":1}',
    ],
    "filtering": [
        "null", "{}", '{"epsilon":{"widths":1},"accumulate":"add","depth":"mean"}',
        '{"stack_from":null,"epsilon":{"interval":0},"accumulate":"max","depth":"weighted"}',
        '{"stack_from":1,"subsampled":2,"epsilon":{"widths":2},"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"subsampled":null,"epsilon":{"widths":2},"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"joined":null,"epsilon":{"widths":2},"accumulate":"add","depth":"mean"}',
        '{"stack_from":9,"joined":true,"epsilon":{"widths":2},"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"subsampled":9,"epsilon":{"widths":2},"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"joined":true,"epsilon":{"widths":-2},"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"epsilon":{"widths":1,"interval":1},"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"epsilon":{},"accumulate":"add","depth":"mean"}', '{"stack_from":1,"epsilon":1,"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"epsilon":{"widths":1e39},"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"epsilon":{"widths":1,"more":1},"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"epsilon":{"widths":0},"accumulate":"add","depth":"mean"}',
        '{"stack_from":1,"epsilon":{"widths":1},"accumulate":"add"}', '{"stack_from":1,"epsilon":{"widths":1},"depth":"mean"}',
        '{"stack_from":1,"epsilon":{"interval":1},"accumulate":"min","depth":"mean"}', '{"stack_from":1,"accumulate":"add","depth":"mean"}',
        '{"stack_from":4294967296,"epsilon":{"widths":1},"accumulate":"add","depth":"mean"}',
        '{"stack_from":0,"epsilon":{"widths":1},"accumulate":"add","depth":"mean","more":3}',
    ],
    "light_samples": ["0", "1", "4294967295", "4294967296", "null", "1.5"],
    "depth_tolerance": ["0", "-0.0", "-1", "1e39", "null", "1e-50"],
    "eyes": ["null", "[]", "[[0,0,0]]", "[[0,0,0],[1,1,1]]", "[[0,0],[1,1]]", "[[0,0,0],[1,1,1e39]]", "[[0,0,0],[1,1,null]]", "[[0,0,0],[0,0,0],[0,0,0]]"],
    "gap": ["0", "-0.0", "-1", "1e39", "null", '"1"'],
    "tolerance": ["0", "-0.0", "0.03125", "0.0625", "1", "0.99999999", "0.99999997", "null", "-1e-50", "1e-50", "0.1"],
}
OPTIONAL["folded"] = OPTIONAL["left_out"]


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
