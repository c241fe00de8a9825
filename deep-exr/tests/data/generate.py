"""Makes the small OpenEXR files beside it: `pip install OpenEXR==3.5.3 numpy`.

Every value follows from its pixel and its place in it, exactly in half
precision; the tests compute the same.
"""
import numpy as np
import OpenEXR

WIDTH, HEIGHT, X0, Y0 = 6, 5, -2, -3


def count(x, y):
    return 0 if y == 2 else (3 * x + 5 * y) % 4


VALUES = {
    'Z': lambda x, y, s: 4 * y + x + 1 + s / 4,
    'ZBack': lambda x, y, s: 4 * y + x + 1 + s / 4 + (s + 1) / 8,
    'A': lambda x, y, s: (s % 4 + 1) / 4,
    'R': lambda x, y, s: 0.5,
    'id': lambda x, y, s: 70000 + s,
}
for colour, (short, other) in enumerate([('AR', 'RA'), ('AG', 'GA'), ('AB', 'BA')]):
    VALUES[short] = VALUES[other] = lambda x, y, s, c=colour: (x + 8 * c + 1) / 32


def channels(names, kind, times=1):
    """Columns of these channels; `kind` is a type, or one for each name."""
    result = {}
    for name in names:
        own = kind.get(name) if isinstance(kind, dict) else kind
        dtype = np.uint32 if name == 'id' else own
        pixels = np.empty((HEIGHT, WIDTH), object)
        for y in range(HEIGHT):
            for x in range(WIDTH):
                n = times * count(x, y)
                values = [VALUES[name](x, y, s) for s in range(n)]
                pixels[y, x] = np.array(values, dtype) if n else None
        result[name] = pixels
    return result


def header(kind, compression, **more):
    result = {
        'type': kind,
        'compression': compression,
        'dataWindow': ((X0, Y0), (X0 + WIDTH - 1, Y0 + HEIGHT - 1)),
        'displayWindow': ((0, 0), (7, 7)),
        **more,
    }
    if kind in (OpenEXR.deeptile, OpenEXR.tiledimage):
        tiles = OpenEXR.TileDescription()
        tiles.xSize, tiles.ySize = 4, 3
        tiles.mode, tiles.roundingMode = OpenEXR.ONE_LEVEL, OpenEXR.ROUND_DOWN
        result['tiles'] = tiles
    return result


def write(path, head, body):
    with OpenEXR.File(head, dict(body)) as file:
        file.write(path)


COLOURED = ['Z', 'ZBack', 'A', 'AR', 'AG', 'AB']
SCAN, TILE = OpenEXR.deepscanline, OpenEXR.deeptile
NONE, RLE, ZIPS = OpenEXR.NO_COMPRESSION, OpenEXR.RLE_COMPRESSION, OpenEXR.ZIPS_COMPRESSION

camera = np.arange(16, dtype=np.float32).reshape(4, 4)
write('scan_zips_half.exr', header(SCAN, ZIPS, worldToCamera=camera, comments='kept'),
      channels(COLOURED, np.float16))
write('scan_none_float.exr', header(SCAN, NONE), channels(['Z', 'A'], np.float32))
write('scan_rle_opaque.exr', header(SCAN, RLE), channels(['Z', 'R', 'ZBack'], np.float16))
write('tile_none_float.exr', header(TILE, NONE), channels(COLOURED, np.float32))
write('tile_zips_ids.exr', header(TILE, ZIPS, lineOrder=OpenEXR.RANDOM_Y),
      channels(['Z', 'A', 'id'], np.float16))
write('tile_rle_other_names.exr', header(TILE, RLE, lineOrder=OpenEXR.DECREASING_Y),
      channels(['Z', 'RA', 'GA', 'BA'], np.float16))

# Enough samples to shrink; two and four bytes a value, in turns.
ZSTD = OpenEXR.ZSTD_COMPRESSION
MIXED = {'A': np.float32, 'R': np.float16, 'Z': np.float16, 'ZBack': np.float32}
write('scan_zstd_mixed.exr', header(SCAN, ZSTD), channels(['Z', 'ZBack', 'A', 'R', 'id'], MIXED, 40))
write('scan_zstd_half.exr', header(SCAN, ZSTD), channels(['Z', 'ZBack', 'A'], np.float16, 40))
write('tile_zstd_float.exr', header(TILE, ZSTD), channels(['Z', 'ZBack', 'A'], np.float32, 40))

yy, xx = np.mgrid[0:HEIGHT, 0:WIDTH]
flat = {'Z': (4.0 * yy + xx + 1).astype(np.float32), 'A': ((xx + 1) / 32).astype(np.float16)}
write('flat_zip.exr', header(OpenEXR.scanlineimage, OpenEXR.ZIP_COMPRESSION), flat)
write('flat_tile_piz.exr', header(OpenEXR.tiledimage, OpenEXR.PIZ_COMPRESSION), flat)
write('flat_no_depth.exr', header(OpenEXR.scanlineimage, NONE), {'A': flat['A'].copy()})

parts = [
    OpenEXR.Part(header(OpenEXR.scanlineimage, OpenEXR.ZIP_COMPRESSION),
                 {'Z': flat['Z'].copy()}, 'beauty'),
    OpenEXR.Part(header(SCAN, ZIPS), channels(['Z', 'A'], np.float16), 'left'),
    OpenEXR.Part(header(TILE, RLE), channels(['Z', 'ZBack'], np.float16), 'right'),
]
with OpenEXR.File(parts) as file:
    file.write('parts.exr')
