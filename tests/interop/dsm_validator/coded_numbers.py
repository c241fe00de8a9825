"""Numbers of block 2 (section 7): bits from the front of a payload, tokens of given frequencies from its end."""

import numpy as np

from .fault import demand

KINDS = 30
MOST_TOKENS = 64
SHARES = 1024
LEAST_STATE = 1 << 16
MOST_PLACE = 129


class Bits:
    """A string of bits, the lowest of a byte first, read from `first` on."""

    def __init__(self, payload, first, place):
        self.payload, self.at, self.place = payload, 8 * first, place

    def take(self, count):
        """A number of so many bits, its lowest first."""
        demand(self.at + count <= 8 * len(self.payload), self.place, "its bit string does not end within it")
        number = 0
        for index in range(count):
            number |= (self.payload[self.at >> 3] >> (self.at & 7) & 1) << index
            self.at += 1
        return number

    def gamma(self):
        zeros = 0
        while self.take(1) == 0:
            zeros += 1
            demand(zeros < 16, self.place, "a number of its frequencies is too long")
        number = (1 << zeros | self.take(zeros)) - 1
        demand(number < 2**16 - 1, self.place, "a number of its frequencies is too large")
        return number

    def finish(self):
        """The byte behind the last, whose other bits are zero."""
        while self.at & 7:
            demand(self.take(1) == 0, self.place, "bits behind its last are not zero")
        return self.at >> 3


def unfolded(number):
    """The signed number that (d << 1) XOR (d >> 31) stands for."""
    return -(number >> 1) - 1 if number & 1 else number >> 1


def _weight(place):
    return (4 + (place - 1) % 4) << ((place - 1) // 4) if place else 0


def _frequencies(bits):
    """How many shares each token of a kind has; none of a kind without tokens."""
    count = bits.gamma()
    demand(count <= MOST_TOKENS, bits.place, "a kind has more than 64 tokens")
    weights, scale = [], 0
    for _ in range(count):
        scale += unfolded(bits.gamma())
        demand(0 <= scale <= MOST_PLACE, bits.place, "a place on the scale of weights is none")
        weights.append(_weight(scale))
    total = sum(weights)
    if total == 0:
        return []
    shares = [max(SHARES * weight // total, 1) if weight else 0 for weight in weights]
    largest = weights.index(max(weights))
    shares[largest] = SHARES - (sum(shares) - shares[largest])
    demand(shares[largest] > 0, bits.place, "the shares of a kind's tokens are more than 1024")
    return shares


class Numbers:
    """The numbers of a payload, kind by kind as they are asked for."""

    def __init__(self, payload, place):
        demand(len(payload) >= 10, place, "its payload is too short")
        self.payload, self.place = payload, place
        self.bits = Bits(payload, 2, place)
        self.ends = [np.cumsum(_frequencies(self.bits)).astype(int).tolist() for _ in range(KINDS)]
        self.states = [int.from_bytes(payload[at : at + 4], "little") for at in (len(payload) - 8, len(payload) - 4)]
        self.end = len(payload) - 8
        self.turn = 0

    def _token(self, kind):
        ends, state = self.ends[kind], self.states[self.turn]
        share = state % SHARES
        token = next((token for token, end in enumerate(ends) if share < end), None)
        demand(token is not None, self.place, f"there are no tokens of kind {kind}")
        start = ends[token - 1] if token else 0
        state = (ends[token] - start) * (state // SHARES) + share - start
        if state < LEAST_STATE:
            demand(self.end - 2 >= (self.bits.at + 7) >> 3, self.place, "its words have no end")
            self.end -= 2
            state = state << 16 | int.from_bytes(self.payload[self.end : self.end + 2], "little")
        self.states[self.turn] = state
        self.turn ^= 1
        return token

    def take(self, kind):
        token = self._token(kind)
        if token < 4:
            return token
        high = token >> 1
        return 1 << high | (token & 1) << (high - 1) | self.bits.take(high - 1)

    def flag(self, kind):
        number = self.take(kind)
        demand(number < 2, self.place, "a flag is neither 0 nor 1")
        return number == 1

    def finish(self):
        demand(self.states == [LEAST_STATE] * 2, self.place, "its states do not end as they should")
        demand(self.bits.finish() == self.end, self.place, "its bit string does not end where its words begin")
