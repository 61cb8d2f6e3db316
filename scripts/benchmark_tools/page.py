"""Tables of figures: as markdown, within a page, and compared with their expected ranges."""

import csv
import hashlib
import pathlib
import re


class Table:
    """Rows and columns of figures. Each cell is a number, a text, or None for no figure.

    name: of the section, which is the name of the marker in the page.
    corner: head of the first column. commands: that printed the figures.
    """

    def __init__(self, name, corner, columns, commands=()):
        self.name, self.corner, self.columns = name, corner, list(columns)
        self.commands = list(commands)
        self.rows = []

    def add(self, label, values, digits=2):
        """digits: after the point; one number, or one for each column."""
        values = list(values)
        if len(values) != len(self.columns):
            raise ValueError('%s, %s: %d figures for %d columns' %
                             (self.name, label, len(values), len(self.columns)))
        if isinstance(digits, int):
            digits = [digits] * len(values)
        self.rows.append((label, values, digits))

    def add_absent(self, label):
        """A row without figures: its recording is not there."""
        self.add(label, [None] * len(self.columns))

    def absent(self):
        return {label for label, values, _ in self.rows if all(value is None for value in values)}

    def figures(self):
        """(row, column) -> number, of all cells that are numbers."""
        return {(label, column): value for label, values, _ in self.rows
                for column, value in zip(self.columns, values) if isinstance(value, (int, float))}

    def markdown(self):
        yield '| %s | %s |' % (self.corner, ' | '.join(self.columns))
        numbers = any(isinstance(value, (int, float)) for _, values, _ in self.rows for value in values)
        yield '|---|%s' % (('---:|' if numbers else '---|') * len(self.columns))
        for label, values, digits in self.rows:
            yield '| %s | %s |' % (label, ' | '.join(map(cell, values, digits)))
        if self.commands:
            yield ''
            yield '; '.join('`%s`' % command for command in self.commands)


def cell(value, digits):
    if value is None:
        return ''
    if isinstance(value, str):
        return value
    return '%.*f' % (digits, value)


def filled(text, tables):
    """The page with the tables between their markers, <!-- table: NAME --> and <!-- end -->."""
    for table in tables:
        marker = re.compile(r'(<!-- table: %s -->\n).*?(<!-- end -->)' % re.escape(table.name), re.DOTALL)
        lines = '\n'.join(table.markdown()) + '\n'
        text, count = marker.subn(lambda match: match.group(1) + lines + match.group(2), text)
        if count != 1:
            raise ValueError('the page has %d markers for table %s' % (count, table.name))
    return text


def tables_of(text):
    """name -> row -> column -> cell, of all tables between markers of a page."""
    tables = {}
    for name, body in re.findall(r'<!-- table: (\w+) -->\n(.*?)<!-- end -->', text, re.DOTALL):
        lines = [[entry.strip() for entry in line.strip('|').split('|')]
                 for line in body.splitlines() if line.startswith('|')]
        tables[name] = {line[0]: dict(zip(lines[0][1:], line[1:])) for line in lines[2:]}
    return tables


# Folders of src/ whose code the figures depend on; "include" is that of the public headers.
STAGES = ('detection', 'filtering', 'geometry', 'imaging', 'include', 'matching', 'nodelets', 'odometry', 'parallel',
          'pipeline', 'simd')


def sums_of_stages(repository):
    """folder -> checksum of its code, without comments and line breaks."""
    repository, sums = pathlib.Path(repository), {}
    for stage in STAGES:
        folder = repository / ('include' if stage == 'include' else 'src/' + stage)
        code = ''.join(path.read_text() for path in sorted(folder.rglob('*')) if path.suffix in ('.h', '.cpp'))
        code = ''.join(re.sub('//.*', '', code).split())
        sums[stage] = hashlib.sha256(code.encode()).hexdigest()[:8]
    return sums


def newer_stages(benchmarks, repository):
    """Stages whose code is not that of the tables in the text of docs/benchmarks.md."""
    measured = dict(re.findall('([a-z]+) ([0-9a-f]{8})', tables_of(benchmarks)['machine']['code']['']))
    return {stage for stage, checksum in sums_of_stages(repository).items() if measured.get(stage) != checksum}


# What README says, by figures of docs/benchmarks.md: {table: row: column}.
SUMMARY = [
    ('machine', '{machine: CPU: }'),
    ('time per frame, all three parts', '{speed: whole pipeline, ms: 2 threads} ms on two threads, '
     '{speed: whole pipeline, ms: 1 thread} ms on one; 1242x375, 128 disparities'),
    ("OpenCV's StereoSGBM, disparity only", 'fast mode (3WAY) {speed: OpenCV MODE_SGBM_3WAY, disparity alone, ms: 2 threads} and '
     '{speed: OpenCV MODE_SGBM_3WAY, disparity alone, ms: 1 thread} ms; '
     'MODE_HH {speed: OpenCV MODE_HH, disparity alone, ms: 1 thread} ms on one'),
    ('all three nodelets, live', '{latency: as fast as nothing is lost: reached Hz} Hz without a lost frame; '
     'at 10 Hz the latency is {latency: 10.0: p50 ms} ms (median), {latency: 10.0: p95 ms} ms (95 %)'),
    ('memory', '{latency: 10.0: memory MB} MB: one process with all nodelets and five seconds of images'),
    ('disparity, KITTI 2015', 'D1 {kitti2015: **ours**: D1 interpolated, all} %; of the {kitti2015: **ours**: density, all} % with a disparity {kitti2015: **ours**: D1 of valid pixels, all} %. '
     "OpenCV's MODE_HH: {kitti2015: OpenCV MODE_HH: D1 interpolated, all} %; of {kitti2015: OpenCV MODE_HH: density, all} %, {kitti2015: OpenCV MODE_HH: D1 of valid pixels, all} % *(a)*"),
    ('its variance, drive 0009', 'errors within 1, 2, 3 sigma: {variance: errors within 1 sigma, %: 0009}, '
     '{variance: errors within 2 sigma, %: 0009}, {variance: errors within 3 sigma, %: 0009} % *(a)*'),
    ('odometry, KITTI 0020', 'relative error {ego_motion: KITTI 0020: relative errors, %} % of the way *(a)*'),
    ('moving objects, KITTI', 'recall {moving_objects: KITTI, all: recall, IoU 0.3}, precision {moving_objects: KITTI, all: precision, IoU 0.3} '
     '({moving_objects: KITTI, all: objects} boxes of seven road users) *(a)*'),
    ('people at 0.8 to 2 m', 'recall {near_objects: people, both: recall, IoU 0.3}, precision {near_objects: people, both: precision, IoU 0.3} '
     '({near_objects: people, both: objects} boxes of three people) *(a)*'),
    ('moving objects, synthetic streets', 'recall {synthetic_objects: 11 scenes, test seeds: recall, IoU 0.3}, '
     'precision {synthetic_objects: 11 scenes, test seeds: precision, IoU 0.3} '
     '({synthetic_objects: 11 scenes, test seeds: objects} boxes) *(b)*'),
]


def summarised(readme, benchmarks):
    """README's text with its table of figures, <!-- summary --> to <!-- end -->, from the text of docs/benchmarks.md.

    A line is left out if one of its figures was not measured: its recordings are not there."""
    tables = tables_of(benchmarks)

    def figure(name):
        table, row, column = name.split(': ')
        return tables[table].get(row, {}).get(column.strip(), '')

    def line(what, text):
        figures = {name: figure(name) for name in re.findall(r'{([^}]*)}', text)}
        filled = re.sub(r'{([^}]*)}', lambda match: figures[match.group(1)], text)
        return '| %s | %s |\n' % (what, filled) if all(figures.values()) else ''
    lines = ''.join(line(what, text) for what, text in SUMMARY)
    block = '<!-- summary -->\n| | |\n|---|---|\n' + lines + '<!-- end -->'
    return re.sub(r'<!-- summary -->\n.*?<!-- end -->', lambda _: block, readme, flags=re.DOTALL)


def write_figures(path, tables):
    with open(path, 'w', newline='') as file:
        writer = csv.writer(file)
        writer.writerow(['table', 'row', 'column', 'value'])
        for table in tables:
            for (row, column), value in table.figures().items():
                writer.writerow([table.name, row, column, '%.6g' % value])


def read_ranges(path):
    """(table, row, column) -> (least, most)."""
    with open(path, newline='') as file:
        lines = list(csv.DictReader(line for line in file if not line.startswith('#')))
    ranges = {}
    for line in lines:
        key = line['table'], line['row'], line['column']
        least, most = float(line['least']), float(line['most'])
        if key in ranges or least > most:
            raise ValueError('%s: %s is there twice, or its range is empty' % (path, ' / '.join(key)))
        ranges[key] = least, most
    return ranges


def out_of_range(ranges, tables):
    """A line for each figure that is not within its range, or that is no longer measured."""
    wrong = []
    for table in tables:
        figures = table.figures()
        for (name, row, column), (least, most) in ranges.items():
            if name != table.name or row in table.absent():
                continue
            where = '%s / %s / %s' % (name, row, column)
            value = figures.get((row, column))
            if value is None:
                wrong.append('%s was not measured' % where)
            elif not least <= value <= most:
                wrong.append('%s = %.4g, expected %g to %g' % (where, value, least, most))
    return wrong
