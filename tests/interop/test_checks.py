"""The checks themselves: what they ask reaches every step, and a wrong answer is noticed."""

import re
import unittest

import numpy as np

from check_lookup import FAR, questions, worst
from deep_truth import make_part, next_above, next_below
from tool import Failed


def part_of_two():
    """A point inside a volume and an opaque volume behind in pixel 0, nothing in pixel 1."""
    return make_part("", 2, 1, [3, 0], [2.0, 1.0, 4.0], [2.0, 3.0, 5.0], {"A": [0.5, 0.5, 1.0]})


class Questions(unittest.TestCase):
    def test_every_depth_is_asked_with_its_neighbours_the_middles_and_beyond(self):
        pixel, depth = questions(part_of_two())
        self.assertEqual(depth.dtype, np.float32)
        asked = set(depth[pixel == 0].tolist())
        for event in (1.0, 2.0, 3.0, 4.0, 5.0):
            self.assertLessEqual({event, float(next_below(event)), float(next_above(event))}, asked)
        self.assertLessEqual({1.5, 2.5, 3.5, 4.5, 0.5, 7.5, float(FAR)}, asked)
        self.assertEqual((pixel == 1).sum(), 1)

    def test_depth_zero_is_not_asked(self):
        _, depth = questions(make_part("", 1, 1, [1], [0.0], [2.0], {"A": [0.5]}))
        self.assertTrue((depth > 0).all())


class Worst(unittest.TestCase):
    def setUp(self):
        self.part = part_of_two()
        self.pixel, self.depth = questions(self.part)
        self.truth = self.part.transmittance(self.pixel, self.depth)

    def judge(self, got):
        return worst(self.part, self.pixel, self.depth, self.truth - 1e-6, self.truth + 1e-6, got)

    def test_the_truth_passes_also_as_three_equal_channels(self):
        self.assertEqual(self.judge(self.truth), 0.0)
        self.assertEqual(self.judge(np.repeat(self.truth, 3, axis=1)), 0.0)

    def test_any_single_wrong_answer_is_named(self):
        for row in range(len(self.depth)):
            for wrong in (self.truth[row, 0] + 2e-6, self.truth[row, 0] - 2e-6, np.nan, np.inf):
                got = self.truth.copy()
                got[row] = wrong
                with self.assertRaisesRegex(Failed, "^1 of .*depth " + re.escape(f"{self.depth[row]:.9g} ")):
                    self.judge(got)

    def test_a_step_on_the_wrong_side_of_its_depth_is_noticed(self):
        for shifted in (next_below(self.depth), next_above(self.depth)):
            with self.assertRaises(Failed):
                self.judge(self.part.transmittance(self.pixel, shifted))

    def test_one_wrong_channel_of_three_is_noticed(self):
        got = np.repeat(self.truth, 3, axis=1)
        got[4, 2] += 1e-3
        with self.assertRaisesRegex(Failed, "channel 2"):
            self.judge(got)

    def test_mono_answers_to_colours_that_differ_are_noticed(self):
        part = make_part("", 1, 1, [1], [1.0], None, {"AR": [0.5], "AG": [0.25], "AB": [0.5]})
        pixel, depth = questions(part)
        truth = part.transmittance(pixel, depth)
        with self.assertRaises(Failed):
            worst(part, pixel, depth, truth - 1e-6, truth + 1e-6, truth[:, :1])


if __name__ == "__main__":
    unittest.main()
