#!/usr/bin/python3
"""Checksums of prepared data: sums.csv has a line for each folder or file.

kind     pixels: sha256 of the decoded pixels. The bytes of a PNG file depend on its compression,
         the pixels do not.
         numbers: sha256 of the words of a text, numbers with seven digits: some files of KITTI
         exist in two notations.
         mean: mean grey value. Grey made from colour, or rectified, may differ by rounding.
first    of the first file
all      of all files: for sums, sha256 of their sums, in the order of the names

Usage: sums.py FOLDER prints the table with the sums of a prepared folder.
"""

import collections
import csv
import hashlib
import os
import sys

import cv2

TABLE = os.path.join(os.path.dirname(os.path.realpath(__file__)), 'sums.csv')
COLUMNS = ('path', 'kind', 'files', 'first', 'all')
MEAN_TOLERANCE = 0.6

Row = collections.namedtuple('Row', COLUMNS)


def read_table():
    with open(TABLE, newline='') as file:
        return [Row(**line) for line in csv.DictReader(file)]


def digest(data):
    return hashlib.sha256(data).hexdigest()


def _pixels(path):
    image = cv2.imread(path, cv2.IMREAD_UNCHANGED)
    if image is None:
        return 'no image'
    return digest(('%s %s\n' % (image.shape, image.dtype)).encode() + image.tobytes())


def _numbers(path):
    words = []
    with open(path, encoding='ascii', errors='replace') as file:
        for word in file.read().split():
            try:
                words.append('%.6e' % float(word))
            except ValueError:
                words.append(word)
    return digest(' '.join(words).encode())


def _mean(path):
    image = cv2.imread(path, cv2.IMREAD_UNCHANGED)
    return float('nan') if image is None else float(image.mean())


def measure(folder, path, kind):
    """The line of the table for a folder or file below `folder`."""
    full = os.path.join(folder, path)
    files = [full]
    if os.path.isdir(full):
        files = [os.path.join(full, name) for name in sorted(os.listdir(full))]
    values = [{'pixels': _pixels, 'numbers': _numbers, 'mean': _mean}[kind](file) for file in files]
    if kind == 'mean':
        first, every = '%.2f' % values[0], '%.2f' % (sum(values) / len(values))
    else:
        first, every = values[0], digest(' '.join(values).encode())
    return Row(path, kind, str(len(files)), first, every)


def _same(kind, one, other):
    return abs(float(one) - float(other)) <= MEAN_TOLERANCE if kind == 'mean' else one == other


def differences(folder):
    """Lines that name what is below `folder` and differs from the table."""
    wrong = []
    for row in read_table():
        if not os.path.exists(os.path.join(folder, row.path)):
            continue
        found = measure(folder, row.path, row.kind)
        if found.files != row.files:
            wrong.append('%s: has %s files instead of %s' % (row.path, found.files, row.files))
            continue
        for name in ('first', 'all'):
            value, expected = getattr(found, name), getattr(row, name)
            if not _same(row.kind, value, expected):
                which = 'its first file' if name == 'first' else 'a file after the first'
                if found.files == '1':
                    which = 'the file'
                wrong.append('%s: %s, %s %s instead of %s' % (row.path, which, row.kind, value, expected))
                break
    return wrong


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith('-'):
        print(__doc__)
        return 0 if sys.argv[1:] == ['--help'] else 2
    writer = csv.writer(sys.stdout, lineterminator='\n')
    writer.writerow(COLUMNS)
    for row in read_table():
        found = os.path.exists(os.path.join(sys.argv[1], row.path))
        writer.writerow(measure(sys.argv[1], row.path, row.kind) if found else row)
    return 0


if __name__ == '__main__':
    sys.exit(main())
