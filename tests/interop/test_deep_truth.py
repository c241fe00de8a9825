"""The reference transmittance against hand-computed values and against OpenImageIO's own sample splitting."""

import math
import tempfile
import unittest
from pathlib import Path

import numpy as np
import OpenEXR

import deep_truth
from deep_truth import make_part, next_above, next_below


def one_pixel(samples, names=("A",)):
    """A part of one pixel from tuples (z, z_back, alpha...)."""
    rows = np.array(samples, np.float64)
    alphas = {name: rows[:, 2 + i] for i, name in enumerate(names)}
    return make_part("", 1, 1, [len(rows)], rows[:, 0], rows[:, 1], alphas)


def at(part, depth):
    return part.transmittance([0], [depth])[0].tolist()


class HandComputed(unittest.TestCase):
    def test_a_point_counts_from_its_own_depth_on(self):
        part = one_pixel([(2.0, 2.0, 0.25)])
        self.assertEqual(at(part, next_below(2.0)), [1.0])
        self.assertEqual(at(part, 2.0), [0.75])
        self.assertEqual(at(part, 1e30), [0.75])

    def test_a_back_in_front_of_its_front_is_a_point(self):
        part = one_pixel([(2.0, 1.0, 0.25)])
        self.assertEqual(at(part, 1.5), [1.0])
        self.assertEqual(at(part, 2.0), [0.75])

    def test_a_volume_is_exponential_between_its_depths(self):
        part = one_pixel([(1.0, 3.0, 0.75)])
        self.assertEqual(at(part, 1.0), [1.0])
        self.assertAlmostEqual(at(part, 2.0)[0], 0.5, delta=1e-15)
        self.assertAlmostEqual(at(part, 1.5)[0], math.sqrt(0.5), delta=1e-15)
        self.assertAlmostEqual(at(part, 3.0)[0], 0.25, delta=1e-15)
        self.assertAlmostEqual(at(part, 9.0)[0], 0.25, delta=1e-15)

    def test_an_opaque_volume_blocks_everything_behind_its_front(self):
        part = one_pixel([(1.0, 3.0, 1.0)])
        self.assertEqual(at(part, 1.0), [1.0])
        self.assertEqual(at(part, next_above(1.0)), [0.0])
        self.assertEqual(at(part, 5.0), [0.0])

    def test_overlapping_and_unsorted_samples_multiply(self):
        # Volume [1, 5) of 15/16 halves the light every unit; a point in it and a point behind.
        part = one_pixel([(6.0, 6.0, 0.5), (1.0, 5.0, 0.9375), (3.0, 3.0, 0.5)])
        self.assertAlmostEqual(at(part, 2.0)[0], 0.5, delta=1e-15)
        self.assertAlmostEqual(at(part, next_below(3.0))[0], 0.25, delta=1e-6)
        self.assertAlmostEqual(at(part, 3.0)[0], 0.125, delta=1e-15)
        self.assertAlmostEqual(at(part, 5.0)[0], 0.03125, delta=1e-15)
        self.assertAlmostEqual(at(part, 6.0)[0], 0.015625, delta=1e-15)

    def test_colours_have_their_own_alpha_and_fall_back_to_the_common_one(self):
        part = one_pixel([(1.0, 1.0, 0.5, 0.25)], ("A", "AR"))
        self.assertEqual(at(part, 1.0), [0.75, 0.5, 0.5])
        part = one_pixel([(1.0, 1.0, 0.125, 0.25, 0.5)], ("RA", "GA", "BA"))
        self.assertEqual(at(part, 1.0), [0.875, 0.75, 0.5])

    def test_no_alpha_at_all_is_opaque(self):
        part = make_part("", 1, 1, [1], [4.0], None, {})
        self.assertEqual(at(part, next_below(4.0)), [1.0])
        self.assertEqual(at(part, 4.0), [0.0])

    def test_samples_without_a_usable_depth_are_dropped_and_alphas_clamped(self):
        rows = [(math.nan, 1.0, 0.5), (math.inf, 1.0, 0.5), (-1.0, -1.0, 0.5), (1.0, 1.0, 1.5), (1.0, 1.0, -0.5)]
        part = one_pixel(rows)
        self.assertEqual((part.dropped, part.clamped, part.z.size), (3, 2, 2))
        self.assertEqual(at(part, 1.0), [0.0])

    def test_extreme_alphas_keep_their_precision(self):
        part = one_pixel([(1.0, 3.0, 2.0**-24)])
        self.assertAlmostEqual(1.0 - at(part, 2.0)[0], 2.0**-25, delta=1e-15)
        part = one_pixel([(1.0, 3.0, 1.0 - 2.0**-24)])
        self.assertAlmostEqual(at(part, 2.0)[0], 2.0**-12, delta=1e-18)

    def test_many_pixels_at_once_equal_one_at_a_time(self):
        rng = np.random.default_rng(1)
        counts = rng.integers(0, 5, 60)
        z = rng.uniform(1, 9, counts.sum()).astype(np.float32)
        z_back = z + rng.choice([0.0, 1.0], z.size).astype(np.float32)
        alpha = rng.uniform(0, 1, z.size)
        part = make_part("", 10, 6, counts, z, z_back, {"A": alpha})
        pixel = rng.integers(0, 60, 700)
        depth = rng.uniform(0, 12, 700)
        together = part.transmittance(pixel, depth)
        for limit in (1, 7, 100):
            kept = deep_truth.PAIRS_AT_ONCE
            deep_truth.PAIRS_AT_ONCE = limit
            try:
                np.testing.assert_array_equal(part.transmittance(pixel, depth), together)
            finally:
                deep_truth.PAIRS_AT_ONCE = kept
        for p, d, t in zip(pixel, depth, together[:, 0]):
            expected = 1.0
            for s in range(part.offsets[p], part.offsets[p + 1]):
                front, back = float(part.z[s]), float(part.z_back[s])
                if back > front:
                    share = min(max((d - front) / (back - front), 0.0), 1.0)
                    expected *= (1.0 - alpha[s]) ** share
                elif d >= front:
                    expected *= 1.0 - alpha[s]
            self.assertAlmostEqual(t, expected, delta=1e-14)


class AgainstOpenImageIO(unittest.TestCase):
    """OpenImageIO splits samples at a depth by its own code, in float32: what lies in front multiplies to T."""

    def test_splitting_at_a_depth_leaves_the_same_light(self):
        import OpenImageIO as oiio

        rng = np.random.default_rng(2)
        for _ in range(200):
            count = int(rng.integers(1, 7))
            z = rng.choice(np.arange(1, 9), count).astype(np.float32)
            z_back = z + rng.choice([0.0, 0.5, 2.0, 4.0], count).astype(np.float32)
            alpha = rng.choice([0.0, 0.1, 0.5, 0.99], count)
            alpha[rng.random(count) < 0.1] = 1.0
            part = make_part("", 1, 1, [count], z, z_back, {"A": alpha})
            for depth in rng.uniform(0.5, 13.0, 12):
                data = oiio.DeepData()
                data.init(1, 3, (oiio.TypeFloat,) * 3, ("Z", "ZBack", "A"))
                data.set_samples(0, count)
                for s in range(count):
                    for channel, value in enumerate((z[s], z_back[s], alpha[s])):
                        data.set_deep_value(0, channel, s, float(value))
                data.split(0, float(depth))
                left = 1.0
                for s in range(data.samples(0)):
                    if data.deep_value(0, 1, s) <= depth + 1e-6:
                        left *= 1.0 - data.deep_value(0, 2, s)
                self.assertAlmostEqual(at(part, depth)[0], left, delta=2e-6)


class Reading(unittest.TestCase):
    def test_both_clients_read_the_same_part(self):
        z = np.empty((2, 3), object)
        z_back, alpha = z.copy(), z.copy()
        z[0, 1], z_back[0, 1], alpha[0, 1] = (np.array(v, np.float32) for v in ([3, 1], [3, 2], [0.5, 0.75]))
        z[1, 2], z_back[1, 2], alpha[1, 2] = (np.array(v, np.float32) for v in ([7], [7], [1]))
        header = {
            "type": OpenEXR.deepscanline,
            "compression": OpenEXR.ZIPS_COMPRESSION,
            "dataWindow": ((5, -2), (7, -1)),
            "displayWindow": ((0, 0), (9, 9)),
        }
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "small.exr")
            with OpenEXR.File(header, {"Z": z, "ZBack": z_back, "A": alpha}) as file:
                file.write(path)
            readings = [deep_truth._read_with_openexr(path), deep_truth._read_with_openimageio(path)]
        for parts in readings:
            (part,) = parts
            self.assertEqual((part.width, part.height), (3, 2))
            self.assertEqual(np.array(part.attributes["dataWindow"]).tolist(), [[5, -2], [7, -1]])
            self.assertEqual(np.array(part.attributes["displayWindow"]).tolist(), [[0, 0], [9, 9]])
            self.assertEqual(part.offsets.tolist(), [0, 0, 2, 2, 2, 2, 3])
            self.assertEqual(part.z.tolist(), [3, 1, 7])
            self.assertEqual(part.z_back.tolist(), [3, 2, 7])
            self.assertEqual(part.alpha[:, 0].tolist(), [0.5, 0.75, 1.0])

    def test_a_flat_depth_image_is_one_opaque_point_a_pixel(self):
        z = np.array([[1.0, np.inf], [3.0, 4.0]], np.float32)
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "flat.exr")
            with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"Z": z}) as file:
                file.write(path)
            part = deep_truth.read_part(path)
        self.assertEqual(part.offsets.tolist(), [0, 1, 1, 2, 3])
        self.assertEqual(part.alpha.ravel().tolist(), [1, 1, 1])


if __name__ == "__main__":
    unittest.main()
