"""Licence expressions: may their code be linked into a program under MIT OR Apache-2.0?"""

import re

# Licences that ask for no more than notices. The last four are of fonts, of Unicode's tables and of the
# certificates of authorities, which are data.
ALLOWED = {
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "ISC",
    "MIT",
    "Unlicense",
    "Zlib",
    "OFL-1.1",
    "Ubuntu-font-1.0",
    "Unicode-3.0",
    "CDLA-Permissive-2.0",
}


class NoExpression(ValueError):
    """The text is not a licence expression."""


def is_allowed(expression):
    """Whether an allowed licence can be chosen. Of `OR` (and the old `/`) one part must be allowed, of `AND` all."""
    tokens = re.findall(r"[()]|[^\s()/]+|/", expression)
    allowed, rest = any_of(tokens)
    if rest:
        raise NoExpression(expression)
    return allowed


def any_of(tokens):
    allowed, rest = all_of(tokens)
    while rest and rest[0] in ("OR", "/"):
        other, rest = all_of(rest[1:])
        allowed |= other
    return allowed, rest


def all_of(tokens):
    allowed, rest = one(tokens)
    while rest and rest[0] == "AND":
        other, rest = one(rest[1:])
        allowed &= other
    return allowed, rest


def one(tokens):
    if tokens and tokens[0] == "(":
        allowed, rest = any_of(tokens[1:])
        if rest[:1] != [")"]:
            raise NoExpression(" ".join(tokens))
        return allowed, rest[1:]
    if not tokens or tokens[0] in (")", "AND", "OR", "WITH", "/"):
        raise NoExpression(" ".join(tokens))
    name, rest = tokens[0], tokens[1:]
    if rest[:1] == ["WITH"]:
        name, rest = " ".join(tokens[:3]), tokens[3:]
    return name in ALLOWED, rest
