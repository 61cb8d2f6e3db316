"""Figures of recordings: read from the programs' CSV files, pooled, compared with an earlier run."""

import csv
import math
import os
from collections import OrderedDict, namedtuple

# `better`: +1: more is better, -1: less is better, 0: neither. `weight`: the column that weights a
# recording when all are pooled. `ratio`: columns whose sums are divided instead.
Figure = namedtuple('Figure', 'measurement column title better weight ratio')
Result = namedtuple('Result', 'recording figure value')
Change = namedtuple('Change', 'recording figure before now worse')


def _figures(measurement, weight, rows):
    return [Figure(measurement, column, title, better, weight, ratio)
            for column, title, better, ratio in rows]


FIGURES = OrderedDict(((f.measurement, f.column), f) for f in (
    _figures('disparity', 'images', (
        ('d1_percent', 'outliers of known disparities [%]', -1, None),
        ('d1f_percent', 'outliers, unknown counted as such [%]', -1, None),
        ('density_percent', 'density where there is truth [%]', 1, None),
        ('rms_px', 'rms error of inliers [px]', -1, None),
        ('nll', 'negative log likelihood of the variance [nats]', -1, None),
        ('mean_width_px', 'disparities searched per pixel', -1, None),
        ('ms', 'disparity [ms per frame]', -1, None))) +
    _figures('odometry', 'motions', (
        ('translation_error_m', 'motion error per frame [m]', -1, None),
        ('rotation_error_deg', 'motion error per frame [deg]', -1, None),
        ('translation_error_percent', 'error of the path [%]', -1, None),
        ('median_normalized_error', 'normalised error of the motion, median', 0, None),
        ('lost', 'frames lost', -1, None),
        ('median_ms', 'ego-motion [ms per frame]', -1, None))) +
    _figures('detection', 'frames', (
        ('recall', 'recall of moving objects', 1, ('found', ('demanded',))),
        ('precision', 'precision of moving objects', 1, ('found', ('found', 'false_boxes'))),
        ('false_boxes_per_frame', 'false boxes per frame', -1, ('false_boxes', ('frames',))),
        ('mean_iou', 'IoU of boxes', 1, None),
        ('median_distance_error_m', 'distance error, median [m]', -1, None),
        ('median_speed_error_mps', 'speed error, median [m/s]', -1, None),
        ('id_switches', 'id switches', -1, None))) +
    _figures('replay', 'pairs', (
        ('pairs', 'stereo pairs', 0, None),
        ('unmatched', 'left images without partner', -1, None),
        ('lost_percent', 'frames whose motion is lost [%]', -1, None),
        ('unpredicted_percent', 'frames without prediction [%]', -1, None),
        ('density_percent', 'density of the disparity [%]', 0, None),
        ('objects_per_frame', 'moving objects per frame', 0, None),
        ('median_ms', 'whole frame, median [ms]', -1, None),
        ('p95_ms', 'whole frame, 95 % [ms]', -1, None)))))
# Pooled as sums; all others as means.
SUMMED = {('odometry', 'lost'), ('detection', 'id_switches'), ('replay', 'pairs'),
          ('replay', 'unmatched')}
# Changes below this share are ignored: the time of one program varies as much.
NOISE = {'ms': 0.1}


def number(text):
    try:
        value = float(text)
    except (TypeError, ValueError):
        return math.nan
    return value if math.isfinite(value) else math.nan


def read_row(path):
    """The line of a program's CSV for the whole recording; None if there is none."""
    if not os.path.isfile(path):
        return None
    with open(path, newline='', encoding='utf-8') as file:
        for row in csv.DictReader(file):
            if row.get('group', 'all') == 'all':
                return row
    return None


def pooled(figure, rows):
    """The figure of all recordings together; NaN if no recording has it."""
    if figure.ratio:
        above, below = figure.ratio
        known = [row for row in rows if not math.isnan(number(row.get(above)))]
        total = sum(number(row[column]) for row in known for column in below)
        return sum(number(row[above]) for row in known) / total if total else math.nan
    known = [(number(row.get(figure.column)), number(row.get(figure.weight))) for row in rows]
    known = [(value, weight) for value, weight in known if not math.isnan(value)]
    if not known:
        return math.nan
    if (figure.measurement, figure.column) in SUMMED:
        return sum(value for value, _ in known)
    weights = sum(weight for _, weight in known)
    return sum(value * weight for value, weight in known) / weights if weights else math.nan


def results_of(rows):
    """Results of `rows`, {(recording, measurement): row}; pooled ones under the name 'all'."""
    results = []
    for figure in FIGURES.values():
        of_figure = [(name, row) for (name, measurement), row in rows.items()
                     if measurement == figure.measurement]
        for name, row in of_figure:
            value = number(row.get(figure.column))
            if not math.isnan(value):
                results.append(Result(name, figure, value))
        if len(of_figure) > 1:
            value = pooled(figure, [row for _, row in of_figure])
            if not math.isnan(value):
                results.append(Result('all', figure, value))
    return results


def csv_of(results):
    return 'recording,measurement,figure,value\n' + ''.join(
        '%s,%s,%s,%.9g\n' % (result.recording, result.figure.measurement, result.figure.column,
                             result.value) for result in results)


def read_results(path):
    """Reads a file that csv_of made. Skips figures that are no longer known."""
    with open(path, newline='', encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    if rows and not {'recording', 'measurement', 'figure', 'value'} <= set(rows[0]):
        raise ValueError('%s: is no results.csv of evaluate_many' % path)
    return [Result(row['recording'], FIGURES[row['measurement'], row['figure']], number(row['value']))
            for row in rows if (row['measurement'], row['figure']) in FIGURES]


def changes(before, now):
    """Changes of figures: the worst change first, the largest gain last.

    `worse` is the change as a share of the larger value; positive: the figure became worse.
    """
    old = {(r.recording, r.figure.measurement, r.figure.column): r.value for r in before}
    found = []
    for result in now:
        figure = result.figure
        was = old.get((result.recording, figure.measurement, figure.column))
        if was is None or math.isnan(was) or figure.better == 0:
            continue
        share = (result.value - was) / max(abs(result.value), abs(was), 1e-9)
        if abs(share) > NOISE.get(figure.column.split('_')[-1], 1e-6):
            found.append(Change(result.recording, figure, was, result.value, -figure.better * share))
    return sorted(found, key=lambda change: -change.worse)
