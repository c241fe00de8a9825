"""The kinds of mutations, each a function of chance and a model of a valid file: the bytes and what was done, or None
where there is nothing to change."""

from . import fields, metadata, payload, structure

# How often each is made beside the others.
MUTATIONS = {
    "prologue": (fields.prologue, 4),
    "section table": (fields.section_table, 5),
    "level record": (fields.level_record, 6),
    "directory entry": (fields.directory_entry, 8),
    "errors": (fields.errors, 3),
    "swapped": (fields.swapped, 3),
    "metadata text": (metadata.text, 6),
    "metadata value": (metadata.value, 12),
    "metadata member": (metadata.member, 12),
    "words": (payload.words, 16),
    "column": (payload.column, 14),
    "words everywhere": (payload.everywhere, 5),
    "depth range": (payload.depth_range, 3),
    "coded numbers": (payload.coded, 6),
    "frame": (payload.frame, 5),
    "packing": (payload.packing, 4),
    "sections": (structure.sections, 3),
    "empty extent": (structure.empty_extent, 2),
    "order": (structure.order, 1),
    "newer version": (structure.newer, 3),
    "levels": (structure.levels, 3),
    "resized": (structure.resized, 3),
    "emptied": (structure.emptied, 3),
    "any byte": (structure.any_byte, 4),
    "unsigned": (structure.unsigned, 2),
}


def mutate(chance, model):
    """A mutated file: its bytes, the name of the mutation and what it did."""
    names = list(MUTATIONS)
    weights = [MUTATIONS[name][1] for name in names]
    while True:
        (name,) = chance.choices(names, weights)
        done = MUTATIONS[name][0](chance, model.copy())
        if done is not None:
            return done[0], name, done[1]
