"""Draws maps and images: for report's pages, and colours for others."""

import os

import cv2
import numpy as np

OUTCOMES = {  # colours of labels and of detected boxes, as bgr
    'label': {'found': (255, 255, 255), 'missed': (255, 0, 255), 'tolerated': (150, 150, 150), 'static': (255, 120, 0)},
    'object': {'right': (0, 200, 0), 'tolerated': (0, 220, 255), 'false': (0, 0, 255)}}


def coloured(values, smallest, largest, colours, known):
    """Colours of a map; black where nothing is known. colours: of OpenCV, or an array of 256."""
    level = np.clip((values - smallest) / (largest - smallest) * 255, 0, 255)
    level = np.nan_to_num(level).astype(np.uint8)
    if isinstance(colours, int):
        picture = cv2.applyColorMap(level, colours)
    else:
        picture = colours[level]
    picture[~known] = 0
    return picture


def read(folder, name, flags=cv2.IMREAD_UNCHANGED):
    picture = cv2.imread(os.path.join(folder, name), flags)
    if picture is None:
        raise OSError(0, 'is not a picture', os.path.join(folder, name))
    return picture


def read_map(folder, name):
    """Values, and where they are known, of a 16-bit PNG as KITTI has them."""
    coded = read(folder, name)
    return coded / 256.0, coded > 0


def write(folder, name, picture):
    """Writes pictures/NAME; returns its path, relative to the folder."""
    os.makedirs(os.path.join(folder, 'pictures'), exist_ok=True)
    if not cv2.imwrite(os.path.join(folder, 'pictures', name), picture):
        raise OSError(0, 'cannot be written: is the disk full?', os.path.join(folder, 'pictures', name))
    return 'pictures/' + name


def errors(left, truth, has_truth, disparity, known):
    """Errors on pixels with truth, over the darkened image: green to yellow up to 3 px, red outliers, magenta
    invalid.
    """
    error = np.abs(disparity - truth)
    colours = np.zeros(left.shape + (3,), np.uint8)
    colours[..., 1] = 200
    colours[..., 2] = np.clip(255 * error / 3, 0, 255)
    colours[(error > 3) & (error > 0.05 * truth)] = (0, 0, 255)
    colours[~known] = (255, 0, 255)
    picture = cv2.cvtColor(left // 2, cv2.COLOR_GRAY2BGR)
    picture[has_truth] = colours[has_truth]
    if has_truth.mean() < 0.25:  # single pixels are hard to see
        for y, x in np.argwhere(has_truth):
            picture[y:y + 2, x:x + 2] = colours[y, x]
    return picture


def frame(item, folder):
    """(caption, picture) of an item "frame" of report.yaml: the left image, and the maps of its methods."""
    left = read(folder, item['left'])
    yield item['frame'] + ', left image', left
    truth, has_truth = read_map(folder, item['truth']) if 'truth' in item else (None, None)
    for method in item['methods']:
        def drawn(what, values, known, largest, unit):
            return ('%s: %s, 0 (blue) to %.0f%s (red)' % (method['name'], what, largest, unit),
                    coloured(values, 0, largest, cv2.COLORMAP_JET, known))
        disparity, known = read_map(folder, method['disparity'])
        yield drawn('disparity', disparity, known, 64 if truth is None else max(16, truth.max()), ' px')
        if truth is not None:
            yield (method['name'] + ': errors, green to yellow up to 3 px, red outliers, magenta invalid',
                   errors(left, truth, has_truth, disparity, known))
        if 'sigma' in method:
            yield drawn('standard deviation', read_map(folder, method['sigma'])[0], known, 2, ' px')
            yield drawn('disparities searched', *read_map(folder, method['width']), int(method['range']), '')
        if 'measured' in method:
            measured, seen = read_map(folder, method['measured'])
            predicted, expected = read_map(folder, method['predicted'])
            caption, picture = drawn('|measured - predicted|', np.abs(measured - predicted), seen & expected, 5, ' px')
            for box in method.get('boxes', []):
                cv2.rectangle(picture, [int(value) for value in box], (255, 255, 255), 3)
            yield caption + ', black unknown; objects that were found', picture


def error_image(levels):
    """Accumulated errors (the paper's figure 3), from white to blue: the 99th percentile of those above 0."""
    errors = np.sort(levels[levels > 0])
    most = errors[len(errors) * 99 // 100] if len(errors) else 1
    rest = np.clip(255 * (1 - levels / most), 0, 255).astype(np.uint8)
    return np.dstack([np.full_like(rest, 255), rest, rest])


def detections(left, rows):
    """Labels (thin) and detected boxes (thick), from rows of one frame, over the left image."""
    picture = cv2.cvtColor(left, cv2.COLOR_GRAY2BGR)
    for row in sorted(rows, key=lambda row: row['what'] == 'label'):  # on top
        colour = OUTCOMES[row['what']][row['verdict']]
        x, y, right, bottom = (round(float(row[key])) for key in ('x1', 'y1', 'x2', 'y2'))
        cv2.rectangle(picture, (x, y, right - x, bottom - y), colour, 1 if row['what'] == 'label' else 2)
        text, place = '', (x, bottom + 12)
        if row['what'] == 'object':
            figures = [cell if cell == '-' else '%.1f' % float(cell) for cell in (row['distance_m'], row['speed_mps'])]
            text, place = '%s: %s m, %s m/s' % (row['id'], *figures), (x, max(10, y - 4))
        elif row['verdict'] == 'missed':
            text = '%s %s, %s' % (row['class'], row['id'], row['motion'])
        for shade, thickness in (((0, 0, 0), 3), (colour, 1)):
            cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.4, shade, thickness, cv2.LINE_AA)
    return picture
