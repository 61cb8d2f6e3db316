"""The plots of pages, as SVG elements. Those of report have rows (of a CSV file, as dictionaries) and an item of report.yaml."""

import io
from math import erf

import matplotlib
import numpy as np

matplotlib.use('svg')
from matplotlib import pyplot  # noqa: E402

matplotlib.rcParams.update({'svg.hashsalt': 'predictive_stereo', 'svg.fonttype': 'none'})

# Okabe and Ito's palette, which colour-blind readers can distinguish.
COLOURS = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#56b4e9', '#e69f00', '#787878', '#000000']


def svg(title, x_label, y_label, curves, equal_axes=False):
    """curves: (name, x, y, style of matplotlib, or 'steps' for bars that begin at x and end at the last x).
    equal_axes: one unit has the same length in x and y, for maps.
    """
    figure, axes = pyplot.subplots(figsize=(8, 5), constrained_layout=True)
    axes.set(title=title, xlabel=x_label, ylabel=y_label)
    axes.grid(color='#e0e0e0')
    for number, (name, x, y, style) in enumerate(curves):
        look = {'color': COLOURS[number % len(COLOURS)], 'label': name}
        if style == 'steps':
            axes.step(x, y, where='post', **look)
        else:
            axes.plot(x, y, style, **look)
    if equal_axes:
        axes.set_aspect('equal', 'datalim')
    else:
        axes.set_ylim(bottom=0)
    axes.legend()
    text = io.StringIO()
    figure.savefig(text, metadata={'Date': None})
    pyplot.close(figure)
    return text.getvalue()[text.getvalue().index('<svg'):]


def column(rows, name):
    return np.array([float(row[name]) for row in rows])


def groups(rows, *keys):
    """Rows by the values of columns, in the order of their first ones."""
    found = {}
    for row in rows:
        found.setdefault(tuple(row[key] for key in keys), []).append(row)
    return found.items()


def of_sequence(rows, item):
    return [row for row in rows if row['sequence'] == item['sequence']]


def outliers(rows, item):
    """Outliers of each frame, of all methods (the paper's figure 5)."""
    curves = [(method, column(of, 'frame'), column(of, 'd1f_percent'), 'o' if len(of) < 3 else '-')
              for (method,), of in groups(of_sequence(rows, item), 'method')]
    return svg(item['sequence'] + ': outliers, invalid pixels counted as such', 'frame', 'D1f [%]', curves)


def variance(rows, item):
    """Observed shares of errors within multiples of sigma, against those of a normal distribution."""
    rows = of_sequence(rows, item)
    expected = [100 * erf(k / np.sqrt(2)) for k in column(rows, 'sigmas')]
    return svg('Variance of ours', "share of a normal distribution's errors within k sigma [%]", 'observed share [%]',
               [('ours', expected, 100 * column(rows, 'share'), '-'), ('ideal', expected, expected, '-')])


def errors(rows, item):
    """Distribution of errors, beside a normal one (the paper's figure 2)."""
    middle, count = column(rows, 'error_px'), column(rows, 'count')
    step = middle[1] - middle[0]
    weights = count / max(count.sum(), 1)
    mean = (weights * middle).sum()
    sigma = np.sqrt(max(1e-9, (weights * middle ** 2).sum() - mean ** 2))
    edges = np.append(middle - step / 2, middle[-1] + step / 2)
    # Half the width of the middle 68.3 %: sigma of a normal distribution.
    quantiles = np.interp([0.1587, 0.8413], np.append(0, np.cumsum(weights)), edges)
    normal = np.exp(-0.5 * ((edges - mean) / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))
    density = np.append(column(rows, 'share') / step, 0)
    return svg('%s: mean %+.3f, sigma %.3f, robust sigma %.3f px' %
               (item['title'], mean, sigma, (quantiles[1] - quantiles[0]) / 2), 'error [px]', 'density [1/px]',
               [('errors', edges, density, 'steps'), ('normal, same variance', edges, normal, '-')])


def paths(rows, _):
    """True and estimated path of each sequence, seen from above."""
    return ''.join(
        svg(sequence, 'to the right [m]', 'ahead [m]',
            [(name, column(of, kind + '_right_m'), column(of, kind + '_ahead_m'), '-')
             for name, kind in (('truth', 'true'), ('estimated', 'estimated'))], equal_axes=True)
        for (sequence,), of in groups(rows, 'sequence'))


KINDS = {'outliers': outliers, 'variance': variance, 'errors': errors, 'paths': paths}
