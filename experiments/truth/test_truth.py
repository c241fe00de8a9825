"""The harness against what can be computed by hand."""

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import numpy as np

import bounds
import embree
import files
import models
import page
import receivers
import scenes
import truth
import vdb
from geometry import MASK, Light, Material, Mesh, Strands, Volume, unit
from measure import error

LIGHT = Light(np.array([0.0, 4.0, 0.0]), np.zeros(3), "rectangle", 1.0, 40.0)
NOTHING = np.full((1, 3), -1)


class Tracer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.library = embree.build(cls.folder.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def light_at(self, geometries, point, own=NOTHING, light=LIGHT, side=64):
        with embree.Truth(self.library, geometries, 1) as truth:
            return truth.visibility(light, np.array([point], float), own, side, 1).mean((0, 1))

    def test_panes_multiply_in_every_channel(self):
        panes = [
            models.quads([models.quad((0, y, 0), (5, 0, 0), (0, 0, -5))], opacity=opacity)
            for y, opacity in ((1, (0.5, 0.2, 0.0)), (2, (0.5, 0.5, 1.0)))
        ]
        np.testing.assert_allclose(self.light_at(panes, (0.1, 0, 0.2)), [0.25, 0.4, 0.0], atol=1e-6)

    def test_half_a_light_is_hidden_by_a_card_to_its_middle(self):
        card = models.quads([models.quad((-2, 2, 0), (2, 0, 0), (0, 0, -2))])
        np.testing.assert_allclose(self.light_at([card], (0, 0, 0)), 0.5, atol=1e-3)
        # From 0.1 to the left the edge stands at 0.1 over x = 0 of the light, which is 1 wide.
        np.testing.assert_allclose(self.light_at([card], (-0.1, 0, 0)), 0.4, atol=0.005)

    def test_a_disk_and_a_sphere_are_as_large_as_their_part(self):
        # The edge stands at 0.25 of the light's diameter from its middle: at half the radius.
        card = models.quads([models.quad((-2 + 0.125, 2, 0), (2, 0, 0), (0, 0, -2))])
        part = np.arccos(0.5) / np.pi - 0.5 * np.sqrt(0.75) / np.pi
        for shape in ("disk", "sphere"):
            light = Light(LIGHT.eye, LIGHT.target, shape, 1.0, 40.0)
            np.testing.assert_allclose(self.light_at([card], (0, 0, 0), light=light, side=128), part, atol=0.003)

    def test_a_mask_is_its_texture_at_the_cutoff(self):
        # Between two texels, 0 and 1, the cutoff 0.75 stands a quarter of a texel beyond the middle.
        material = Material(MASK, 0.75, 1.0, np.array([[0.0, 1.0]], "f4"), wrap=(2, 2))
        card = models.quads([models.quad((0, 2, 0), (2, 0, 0), (0, 0, -2))], [[0, 1], [1, 1], [1, 0], [0, 0]], material)
        # Texels are 2 wide, so that the edge stands at x = 0.5, and at twice that on the light, less the point's place.
        point = (0.5, 0, 0)
        np.testing.assert_allclose(self.light_at([card], point), 1.0, atol=1e-6)
        light = Light(LIGHT.eye + [0.5, 0, 0], LIGHT.target + [0.5, 0, 0], "rectangle", 1.0, 40.0)
        np.testing.assert_allclose(self.light_at([card], point, light=light), 0.5, atol=0.01)

    def test_a_strand_dims_once_however_it_is_cut(self):
        light = Light(LIGHT.eye, LIGHT.target, "point", 0.0, 40.0)
        for cut in (2, 3, 5, 65):
            x = np.linspace(-1, 1, cut)
            points = np.stack([x, np.full(cut, 2.0), np.zeros(cut)], -1).astype("f4")
            strand = Strands(points, np.array([cut]), 0.2, (0.5, 0.5, 0.5))
            # In the middle and beside it, where segments meet and where they don't.
            for place in (0.0, 0.011, 0.5, 0.777):
                np.testing.assert_allclose(self.light_at([strand], (place, 0, 0.0), light=light, side=1), 0.5)

    def test_a_strand_does_not_shade_what_lies_on_it(self):
        x = np.linspace(-1, 1, 9)
        level = Strands(np.stack([x, 0 * x, 0 * x], -1).astype("f4"), np.array([9]), 0.2)
        # Behind its middle line, by a tenth of its radius, and by all of its own segment and those beside it.
        point = np.array([[0.1, -0.01, 0.0]])
        with embree.Truth(self.library, [level], 1) as truth:
            dark = truth.visibility(LIGHT, point, NOTHING, 8, 1).mean()
            free = truth.visibility(LIGHT, point, np.array([[0, 3, 5]]), 8, 1).mean()
        self.assertEqual((dark, free), (0.0, 1.0))
        scene = scenes.Scene("strand", "", [scenes.Thing("curves", "", [models.tuft(3)])])
        (found,) = receivers.draw(scene, LIGHT, 50)
        _, strand = models.tuft(3).segments()
        geometry, first, last = found.own.T
        self.assertTrue((geometry == 0).all() and ((last - first) <= 2).all() and (first < last).all())
        self.assertTrue((strand[first] == strand[last]).all())

    def test_what_lies_behind_a_receiver_does_not_shade_it(self):
        # Where there are strands, rays begin behind the receiver.
        card = models.quads([models.quad((0, -0.01, 0), (2, 0, 0), (0, 0, -2))])
        aside = Strands(np.array([[5, 0, 0], [6, 0, 0]], "f4"), np.array([2]), 0.2)
        np.testing.assert_allclose(self.light_at([card, aside], (0, 0, 0)), 1.0)

    def test_a_picture_has_the_light_that_lookups_have(self):
        ground = models.ground()
        card = models.quads([models.quad((-2, 0, 0), (2, 0, 0), (0, 0, -2))])
        camera = scenes.Camera(eye=(0.0, -0.5, 3.0), target=(0.0, -1.0, 0.0), fov=1.0, resolution=(2, 2))
        with embree.Truth(self.library, [ground, card], 1) as truth:
            seen = truth.picture(LIGHT, camera, 4096, 2.0**-13, 1).mean()
            point = np.array([[0.0, -1 + 2.0**-13, 0.0]])
            asked = truth.visibility(LIGHT, point, NOTHING, 64, 1).mean()
        self.assertAlmostEqual(seen, asked, delta=0.01)


class Numbers(unittest.TestCase):
    def test_the_noise_of_the_truth_is_taken_off(self):
        random = np.random.default_rng(1)
        truth = random.uniform(0, 1, (20_000, 1, 3))
        halves = truth + random.normal(0, 0.05, (20_000, 2, 3))
        answers = truth[:, 0] + random.choice([-0.02, 0.02], (20_000, 3)) + 0.01
        found = error(answers, halves)
        self.assertAlmostEqual(found.rmse, np.hypot(0.02, 0.01), delta=1e-3)
        self.assertAlmostEqual(found.mean, 0.01, delta=1e-3)
        self.assertAlmostEqual(found.noise, 0.05 / np.sqrt(2), delta=1e-3)

    def test_a_volume_is_trilinear_and_ends_a_voxel_beyond(self):
        volume = Volume(np.array([[[1.0, 3.0]]]), np.array([0.0, 0.0, 1.0]), 0.5, 2.0)
        points = np.array([[0, 0, 1.0], [0, 0, 1.25], [0, 0.25, 1.0], [0, 0, 2.0], [0, 0, 0.75], [9, 9, 9]])
        np.testing.assert_allclose(volume.at(points), [2, 4, 1, 0, 1, 0])

    def test_bounds_fail_what_is_above_them(self):
        row = {"scene": "new", "variant": "", "ask": "lookup", "kind": "", "method": "", "receivers": "all"}
        row |= {"default": True, "mean": 0.0, "rmse": bounds.OVER_ALL}
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertTrue(bounds.check([row]))
            self.assertFalse(bounds.check([row | {"rmse": 0.021}]))
            self.assertFalse(bounds.check([row | {"mean": -0.004}]))
            self.assertTrue(bounds.check([row | {"rmse": 0.5, "default": False}]))

    def test_scenes_that_are_measured_again_take_the_place_of_what_they_were(self):
        def rows(*found):
            return [{"scene": name, "rmse": rmse} for name, rmse in found]

        kept = {"program": "old", "seconds": 9, "rows": rows(("a", 1), ("b", 2), ("b", 3), ("c", 4))}
        again = {"program": "new", "seconds": 1, "rows": rows(("b", 5), ("d", 6))}
        found = truth.merged(kept, again)
        self.assertEqual(found["rows"], rows(("a", 1), ("b", 5), ("c", 4), ("d", 6)))
        self.assertEqual(found["later"], {"b": "new", "d": "new"})
        self.assertEqual(page.later(found), ", *b* and *d* by `new`")
        self.assertEqual((found["program"], page.later(kept)), ("old", ""))


class Files(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = Path(self.folder.name)
        self.addCleanup(self.folder.cleanup)

    def test_files_are_read_as_they_were_written(self):
        hair = models.tuft(5)
        files.write_hair(self.path / "a.hair", hair)
        read = files.read_hair(self.path / "a.hair", hair.thickness)
        np.testing.assert_array_equal(read.points, hair.points)
        np.testing.assert_array_equal(read.counts, hair.counts)
        leaves = models.leaves(7)
        files.write_glb(self.path / "a.glb", leaves)
        (mesh,) = files.read_glb(self.path / "a.glb")
        np.testing.assert_array_equal(mesh.positions, leaves.positions)
        np.testing.assert_allclose(mesh.material.alpha, leaves.material.alpha, atol=1e-6)
        knot = models.knot(20, 8)
        files.write_obj(self.path / "a.obj", knot)
        read = files.read_obj(self.path / "a.obj")
        np.testing.assert_array_equal(read.positions, knot.positions)
        np.testing.assert_array_equal(read.triangles, knot.triangles)
        values = models.cloud(16)
        vdb.write(self.path / "a.vdb", values, 0.25)
        read, origin, voxel = vdb.read(self.path / "a.vdb")
        np.testing.assert_array_equal(read, values)
        self.assertEqual((origin.tolist(), voxel), ([0, 0, 0], 0.25))


class Places(unittest.TestCase):
    def test_receivers_are_on_the_side_that_their_kind_says(self):
        scene = next(scene for scene in scenes.generated() if scene.name == "knot")
        found = {one.kind: one.points for one in receivers.draw(scene, scene.light, 200)}
        self.assertEqual(set(found), {"ground", "lit side", "grazing", "turned away"})
        self.assertTrue(np.allclose(found["ground"][:, 1], models.GROUND + receivers.LIFT))

    def test_closed_surfaces_wind_outwards(self):
        for mesh in (models.ball((1, 2, 3), 0.5), models.knot(), models.box((1, 1, 1), (1, 2, 3))):
            corners = mesh.corners() if isinstance(mesh, Mesh) else mesh
            side = receivers.outward(corners)
            normal = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])) * side
            # The volume that the triangles enclose, by the divergence theorem.
            area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
            self.assertGreater((np.einsum("ij,ij->i", normal, corners.mean(1)) * area).sum(), 0)


if __name__ == "__main__":
    unittest.main()
