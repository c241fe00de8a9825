"""Mutations: what is not changed is written as it was, checksums are right again, and every kind of mutation is made."""

import collections
import random
import unittest

import dsm_validator
from check_validator import agree
from dsm_mutations import maps
from dsm_mutations.kinds import MUTATIONS, mutate
from dsm_mutations.model import Model
from dsm_mutations.sign import resign
from dsm_validator.fault import BeyondLimits, Fault

GOLDEN = dict(maps.golden())


class Writing(unittest.TestCase):
    def test_a_model_is_written_as_the_map_it_is(self):
        for name, data in GOLDEN.items():
            written = Model.read(data).write()
            self.assertIsNone(dsm_validator.verdict(written), name)
            again = Model.read(written)
            for one, other in zip(Model.read(data).tiles(), again.tiles(), strict=True):
                self.assertEqual(one.words.tolist(), other.words.tolist(), name)

    def test_signing_changes_no_valid_file_and_mends_every_checksum(self):
        for name, data in GOLDEN.items():
            self.assertEqual(resign(data), data, name)
            # A payload's byte: its directory, that one's section and the table have to follow.
            changed = bytearray(data)
            changed[64] ^= 1
            fault = dsm_validator.verdict(resign(changed))
            self.assertNotIn("checksum", str(fault), name)
            self.assertIn("checksum", str(dsm_validator.verdict(bytes(changed))), name)


class Kinds(unittest.TestCase):
    def test_every_kind_of_mutation_is_made_and_most_are_found_or_harmless_as_they_may_be(self):
        chance = random.Random(2)
        models = [Model.read(data) for data in GOLDEN.values()]
        verdicts = collections.defaultdict(collections.Counter)
        for number in range(600):
            data, name, _ = mutate(chance, models[number % len(models)])
            verdicts[name][dsm_validator.verdict(data) is None] += 1
        self.assertEqual(set(verdicts), set(MUTATIONS))
        total = sum(verdicts.values(), collections.Counter())
        self.assertGreater(total[True], 100)
        self.assertGreater(total[False], 300)
        self.assertEqual(verdicts["unsigned"][True], 0)
        self.assertEqual(verdicts["order"][False], 0)


class Agreeing(unittest.TestCase):
    def test_verdicts_agree_where_both_take_a_file_or_neither_does(self):
        fault, errors = Fault("here", "wrong"), ["a.dsm: wrong"]
        self.assertTrue(agree(None, None))
        self.assertTrue(agree(fault, errors))
        self.assertFalse(agree(None, errors))
        self.assertFalse(agree(fault, None))

    def test_limits_are_a_program_s_own(self):
        errors = ["a.dsm: tiles: 5 is more than the limit of 4"]
        self.assertTrue(agree(None, errors))
        self.assertTrue(agree(BeyondLimits("here", "much"), None))
        self.assertFalse(agree(None, [*errors, "a.dsm: wrong"]))


if __name__ == "__main__":
    unittest.main()
