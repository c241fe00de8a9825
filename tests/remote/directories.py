"""Where the tiles of a `.dsm` file stand: as much of docs/format/dsm-1.md as counting bytes takes."""

import struct


def padded(length):
    return -(-length // 64) * 64


class Directories:
    """Tile sizes and extents of the finest level."""

    def __init__(self, path):
        data = path.read_bytes()
        table, count = struct.unpack_from("<QI", data, 24)
        sections = []
        for index in range(count):
            kind, _, offset, length = struct.unpack_from("<4sIQQ", data, table + 32 * index)
            sections.append((kind, offset, length))
        levels = next(offset for kind, offset, _ in sections if kind == b"LEVL")
        _, _, self.width, self.height, _, _, self.tile_width, self.tile_height = struct.unpack_from("<IIIIiiII", data, levels)
        (directory,) = struct.unpack_from("<I", data, levels + 44)
        _, start, length = sections[directory]
        entries = [struct.unpack_from("<QQ", data, start + 64 * index) for index in range(length // 64)]
        columns = -(-self.width // self.tile_width)
        self.tiles = {(index % columns, index // columns): entry for index, entry in enumerate(entries) if entry[0]}

    def touched(self, points):
        """The tiles that hold these points of the raster, and their bytes."""
        tiles = {(int(x) // self.tile_width, int(y) // self.tile_height) for x, y, _ in points}
        tiles &= self.tiles.keys()
        return len(tiles), sum(padded(self.tiles[tile][1]) for tile in tiles)
