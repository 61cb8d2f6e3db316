"""What has to be made of which files; what of them is missing."""

import collections
import os
import shutil

Step = collections.namedtuple('Step', 'target make sources')


class BadInput(Exception):
    """A file of a download is not as expected."""


class Plan:
    """Steps that fill a folder; each makes one file from files of downloads."""

    def __init__(self, root):
        self.root = root
        self.steps = collections.OrderedDict()  # target -> Step
        self.missing = collections.OrderedDict()  # what to download -> paths

    def source(self, download, path):
        """Where the file `path` of a download is below the root; '' where it is missing."""
        for folder in download.folders:
            full = os.path.join(self.root, folder, path)
            if os.path.isfile(full):
                return full
        self.missing.setdefault(download, []).append(path)
        return ''

    def add(self, target, make, *sources):
        """make(target, *sources) writes a file; the target is relative to the output folder."""
        self.steps[target] = Step(target, make, sources)

    def copy(self, target, source):
        self.add(target, copy_file, source)

    def what_is_missing(self):
        """Lines that name what is missing, and where to get it."""
        lines = []
        for download, paths in self.missing.items():
            more = ' and %d more files' % (len(paths) - 1) if len(paths) > 1 else ''
            lines.append('%s%s: download %s from %s' % (paths[0], more, download.name, download.page))
        return lines

    def run(self, out):
        for step in self.steps.values():
            target = os.path.join(out, step.target)
            os.makedirs(os.path.dirname(target), exist_ok=True)
            step.make(target, *step.sources)


def copy_file(target, source):
    """A copy with the rights of a new file: downloads may be read-only."""
    shutil.copyfile(source, target)


def write(target, text):
    with open(target, 'w', encoding='ascii') as file:
        file.write(text)


def read_lines(path):
    """Lines of a text, without empty ones."""
    try:
        with open(path, encoding='ascii') as file:
            return [line.rstrip('\r\n') for line in file if line.strip()]
    except ValueError as error:
        raise BadInput('%s: is no plain text (%s); unpack it again' % (path, error)) from error


def cut_lines(first, count):
    """A step that keeps `count` lines from line `first` on, counted from 0."""
    def make(target, source):
        lines = read_lines(source)
        if len(lines) < first + count:
            raise BadInput('%s: has %d lines, lines %d to %d are needed; unpack it again' %
                           (source, len(lines), first + 1, first + count))
        write(target, ''.join(line + '\n' for line in lines[first:first + count]))
    return make
