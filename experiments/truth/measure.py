"""How far answers are off, with the noise of the truth taken off."""

from dataclasses import asdict, dataclass

import numpy as np


@dataclass
class Error:
    """RMSE and mean of answers less the truth, over receivers and channels."""

    count: int
    rmse: float
    mean: float
    noise: float  # of the truth, one standard deviation of a receiver

    def as_json(self):
        return {key: round(value, 6) if isinstance(value, float) else value for key, value in asdict(self).items()}


def error(answers, halves, own_halves=None):
    """The error of answers (n, 3) against two independent halves of the truth (n, 2, 3).

    The truth is their mean; a quarter of the squares of their differences is its variance, which is taken off. So
    is that of the answers if they have halves of their own.
    """
    truth = halves.mean(1)
    variance = np.mean((halves[:, 0] - halves[:, 1]) ** 2) / 4
    own = 0.0 if own_halves is None else np.mean((own_halves[:, 0] - own_halves[:, 1]) ** 2) / 4
    difference = answers - truth
    square = np.mean(difference**2) - variance - own
    return Error(len(answers), float(np.sqrt(max(square, 0))), float(difference.mean()), float(np.sqrt(variance)))
