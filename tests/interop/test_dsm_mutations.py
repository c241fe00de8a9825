"""Mutations: what is not changed is written as it was, checksums are right again, every kind of mutation is made."""

import collections
import random
import tempfile
import unittest
from pathlib import Path

import dsm_validator
from check_validator import Batch, agree
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


# Stands for the program: says what the first word of each file is, or does what it says.
PROGRAM = """#!/bin/sh
shift 3
sep=""
out='{"files":['
for path; do
    case $(cat "$path") in
        panic) echo "thread 'main' panicked" >&2; exit 101 ;;
        hang) exec sleep 60 ;;
        good) out="$out$sep"'{"ok":true,"errors":[]}' ;;
        *) out="$out$sep"'{"ok":false,"errors":["bad.dsm: bad"]}' ;;
    esac
    sep=,
done
echo "$out]}"
exit 1
"""


class Batches(unittest.TestCase):
    def test_of_many_files_the_ones_that_break_the_program_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "program"
            program.write_text(PROGRAM)
            program.chmod(0o755)
            paths = [Path(folder) / f"{number}.dsm" for number in range(7)]
            for path, text in zip(paths, ("good", "bad", "good", "panic", "bad", "hang", "good")):
                path.write_text(text)
            batch = Batch(str(program), paths, seconds=1)
        for number in (0, 2, 6):
            self.assertIsNone(batch.said[paths[number]])
        for number in (1, 4):
            self.assertEqual(batch.said[paths[number]], ["bad.dsm: bad"])
        self.assertEqual(len(batch.complaints), 2)
        self.assertRegex(batch.complaints[0], "3.dsm: exit status 101: .*panicked")
        self.assertRegex(batch.complaints[1], "5.dsm: exit status none in 1 s")


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
