"""CRC-32C (section 1), 64 bytes at a time: extents are padded to that."""

import numpy as np

POLYNOMIAL = 0x82F63B78
ROW = 64


def _byte_table():
    table = np.arange(256, dtype=np.uint32)
    for _ in range(8):
        table = np.where(table & 1, (table >> 1) ^ np.uint32(POLYNOMIAL), table >> 1).astype(np.uint32)
    return table


def _place_tables(steps):
    """tables[i][b]: what byte b adds to the remainder of a message, `steps` - i bytes before its end."""
    first = _byte_table()
    tables = np.empty((steps, 256), np.uint32)
    tables[-1] = first
    for place in range(steps - 2, -1, -1):
        tables[place] = (tables[place + 1] >> 8) ^ first[tables[place + 1] & 0xFF]
    return tables


_PLACES = _place_tables(ROW)
# A remainder of four bytes, moved on by a row of zeros, is that of its bytes at the row's begin.
_ROW_ON = [table.tolist() for table in _PLACES[:4]]


def crc32c(data):
    """The checksum of bytes."""
    # The start value is the same as the first four bytes inverted; zeros before them change nothing.
    if len(data) < 4:
        return _short(data)
    length = len(data)
    rows = -(-length // ROW)
    message = np.zeros(rows * ROW, np.uint8)
    message[-length:] = np.frombuffer(data, np.uint8)
    message[-length : rows * ROW - length + 4] ^= 0xFF
    remainders = np.bitwise_xor.reduce(_PLACES[np.arange(ROW), message.reshape(rows, ROW)], axis=1)
    a, b, c, d = _ROW_ON
    crc = 0
    for remainder in remainders.tolist():
        crc = a[crc & 0xFF] ^ b[crc >> 8 & 0xFF] ^ c[crc >> 16 & 0xFF] ^ d[crc >> 24] ^ remainder
    return crc ^ 0xFFFFFFFF


def _short(data):
    crc = 0xFFFFFFFF
    table = _PLACES[-1]
    for byte in data:
        crc = crc >> 8 ^ int(table[(crc ^ byte) & 0xFF])
    return crc ^ 0xFFFFFFFF
