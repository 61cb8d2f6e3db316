"""Tables of figures: as markdown, within a page, and compared with their expected ranges."""

import csv
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
            if name != table.name:
                continue
            where = '%s / %s / %s' % (name, row, column)
            value = figures.get((row, column))
            if value is None:
                wrong.append('%s was not measured' % where)
            elif not least <= value <= most:
                wrong.append('%s = %.4g, expected %g to %g' % (where, value, least, most))
    return wrong
