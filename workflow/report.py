"""The page of evaluate_many: failures, changes, tables, plots."""

import html
import math
import os
import sys
from collections import OrderedDict

import figures

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), '../scripts/page_tools'))
import pages  # noqa: E402

STYLE = '''
tr.all td { font-weight: bold } .worse { color: #b00 } .better { color: #070 }
svg { background: #fafafa; border: 1px solid #ddd; margin: .3em }
'''


def short(value):
    return '-' if value is None or math.isnan(value) else '%.4g' % value


def plot(figure, values, before):
    """The figure over recordings as an SVG: one bar each, in the list's order; line: the earlier value."""
    width, height, left, bottom = 600, 220, 60, 20
    known = list(values.values()) + [before[name] for name in values if name in before]
    low, high = min(0.0, *known), max(0.0, *known)
    high = high if high > low else low + 1.0
    step = (width - left) / len(values)

    def y(value):
        return 30 + (height - bottom - 30) * (high - value) / (high - low)
    parts = ['<text x="6" y="18" font-size="13">%s</text>' % html.escape(
        '%s: %s' % (figure.measurement, figure.title))]
    for value in (low, high):
        parts.append('<text x="%d" y="%.1f" font-size="11" text-anchor="end">%s</text>' %
                     (left - 4, y(value) + 4, short(value)))
    for index, (name, value) in enumerate(values.items()):
        x = left + index * step
        top, under = sorted((y(value), y(0.0)))
        title = '%s: %s' % (name, short(value))
        if name in before:
            title += ' (before: %s)' % short(before[name])
        parts.append('<g><title>%s</title><rect x="%.2f" y="%.2f" width="%.2f" height="%.2f" '
                     'fill="#47a"/>' % (html.escape(title), x + .1 * step, top, .8 * step,
                                        max(under - top, .5)))
        if name in before:
            parts.append('<path d="M%.2f %.2f h%.2f" stroke="#c22" stroke-width="2"/>' %
                         (x, y(before[name]), step))
        parts.append('</g>')
    return '<svg width="%d" height="%d" viewBox="0 0 %d %d">%s</svg>\n' % (
        width, height, width, height, ''.join(parts))


def by_figure(results):
    found = OrderedDict()
    for result in results:
        key = result.figure.measurement, result.figure.column
        found.setdefault(key, OrderedDict())[result.recording] = result.value
    return found


def tail(path, lines=15):
    try:
        with open(path, 'rb') as file:
            file.seek(max(0, os.path.getsize(path) - 20000))
            text = file.read().decode('utf-8', 'replace')
    except OSError:
        return 'no log: the job did not begin'
    return '\n'.join(text.replace('\r', '\n').splitlines()[-lines:])


def failures_section(failures):
    if not failures:
        return '<p>All recordings were measured.</p>'
    return ''.join('<h3>%s, %s</h3><pre>%s</pre>\n' %
                   (html.escape(name), measurement, html.escape(tail(log)))
                   for name, measurement, log in failures)


def changes_section(changes, source):
    rows = [[c.recording, c.figure.measurement, c.figure.title, short(c.before), short(c.now),
             '%+.1f %%' % (100 * c.worse)] for c in changes]
    kinds = ['worse' if c.worse > 0 else 'better' for c in changes]
    worse = kinds.count('worse')
    return '<p>Against %s: %d figures became worse, %d better. What became worse is first.</p>' % (
        html.escape(source), worse, len(kinds) - worse) + \
        (pages.table(['recording', 'measurement', 'figure', 'before', 'now', 'worse by'], rows, classes=kinds)
         if rows else '')


def tables_section(results, names):
    found = by_figure(results)
    text = ''
    for measurement in OrderedDict.fromkeys(key[0] for key in found):
        columns = [key for key in found if key[0] == measurement]
        rows = [[name] + [short(found[key].get(name)) for key in columns] for name in names + ['all']
                if any(name in found[key] for key in columns)]
        text += '<h3>%s</h3>\n' % measurement + pages.table(
            ['recording'] + [figures.FIGURES[key].title for key in columns], rows,
            classes=['all' if row[0] == 'all' else None for row in rows])
    return text


def page(names, results, failures, before, source):
    """The page as a text.

    @param before  results of an earlier run from the file `source`; None: there is none.
    """
    old = by_figure(before or [])
    plots = ''
    for key, values in by_figure(results).items():
        single = OrderedDict((name, value) for name, value in values.items() if name != 'all')
        plots += plot(figures.FIGURES[key], single, old.get(key, {}))
    failed = len({name for name, _, _ in failures})
    text = '<p class="note">%d of them failed.</p>\n' % failed
    text += '<h2>Failures</h2>\n' + failures_section(failures)
    if before is not None:
        text += '<h2>Changes</h2>\n' + changes_section(figures.changes(before, results), source)
    text += '<h2>Tables</h2>\n<p class="note">"all": means weighted by frames; of counts (recall, ' \
        'precision, false boxes) the figures of all recordings as one; of numbers of events the ' \
        'sums.</p>\n' + tables_section(results, names)
    text += '<h2>Plots</h2>\n<p class="note">A bar is a recording, in the order of the list; the ' \
        'mouse shows its name.%s</p>\n' % (' Red: before.' if before else '') + plots
    return pages.page('%d recordings' % len(names), text, STYLE)
