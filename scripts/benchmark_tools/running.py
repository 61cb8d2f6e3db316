"""Runs the package's tools and reads what they print."""

import contextlib
import csv
import os
import re
import shlex
import signal
import socket
import subprocess
import time


class MissingInput(Exception):
    """A tool, or data that a section needs, is not there."""


class ToolFailed(Exception):
    """A tool ended with an error, or printed something else than expected."""


class Runner:
    """Runs tools in the folder of the KITTI data; the same command runs only once.

    quick: sections measure only a few frames.
    """

    def __init__(self, build, kitti, out, quick=False):
        self.tools = os.path.join(os.path.abspath(build), 'devel/lib/predictive_stereo')
        self.kitti = os.path.abspath(kitti) if kitti else ''
        self.out, self.quick = out, quick
        self._done = {}
        self.commands = []  # since the last take_commands()
        os.makedirs(os.path.join(out, 'logs'), exist_ok=True)

    def require(self, needs):
        """needs: 'tool:NAME' or a path below the KITTI folder."""
        missing = []
        for need in dict.fromkeys(needs):
            if need.startswith('tool:'):
                path = os.path.join(self.tools, need[5:])
                if not os.access(path, os.X_OK):
                    missing.append('%s: build it with --target all predictive_stereo_benchmarks, or give '
                                   '--build FOLDER' % path)
            elif not self.kitti:
                missing.append('%s: give --kitti FOLDER (docs/benchmarks.md says what is in it)' % need)
            elif not os.path.exists(os.path.join(self.kitti, need)):
                missing.append('%s: there is none in --kitti %s' % (need, self.kitti))
        if missing:
            raise MissingInput('missing:\n  ' + '\n  '.join(missing))

    def few(self, usual, quick):
        return quick if self.quick else usual

    def path(self, name):
        return os.path.join(self.out, name)

    def take_commands(self):
        commands, self.commands = self.commands, []
        return list(dict.fromkeys(commands))

    def text(self, tool, *arguments, shown=None, hidden=(), env=None):
        """What the tool prints.

        shown: how the page names the command, where that differs.
        hidden: arguments that the page does not show, such as names of output files.
        """
        self.commands.append(shown or shlex.join([tool, *arguments]).replace(self.out + '/', ''))
        command = [tool, *arguments, *hidden]
        key = shlex.join(command)
        if key not in self._done:
            self._done[key] = self._run(command, env)
        return self._done[key]

    def _run(self, command, env):
        print('$ ' + shlex.join(command), flush=True)
        log = self.path('logs/%02d_%s.txt' % (len(self._done), command[0]))
        begin = time.monotonic()
        with open(log, 'w') as file:
            file.write('$ %s\n' % shlex.join(command))
            file.flush()
            result = subprocess.run([os.path.join(self.tools, command[0])] + command[1:],
                                    cwd=self.kitti or None, stdout=subprocess.PIPE, stderr=file, text=True,
                                    env=env)
            file.write(result.stdout)
        print('  %.0f s' % (time.monotonic() - begin), flush=True)
        if result.returncode != 0:
            with open(log, errors='replace') as file:
                tail = ''.join(file.readlines()[-5:])
            raise ToolFailed('%s ended with exit status %d (%s):\n%s' %
                             (command[0], result.returncode, log, tail))
        return result.stdout

    def csv(self, tool, *arguments, name, suffix='', shown=None):
        """(lines of the file that --csv writes, what the tool prints).

        suffix: of the file, which some tools add to its name.
        """
        path = self.path('%s.csv' % name)
        text = self.text(tool, *arguments, shown=shown, hidden=('--csv', path))
        with open(path.replace('.csv', suffix + '.csv'), newline='') as file:
            return list(csv.DictReader(file)), text


def number(text):
    """The first number of a text such as '0.91 +- 0.03'; None where it has none."""
    match = re.match(r'\s*([-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)', text)
    return float(match.group(1)) if match else None


def markdown_tables(text):
    """Tables of a text: each a list of rows, heads first; a row is a list of texts."""
    tables, last = [], False
    for line in text.splitlines():
        row = line.startswith('|')
        if row and not re.fullmatch(r'[|:\- ]+', line):
            if not last:
                tables.append([])
            tables[-1].append([cell.strip() for cell in line.strip('|').split('|')])
        last = row
    return tables


def columns(text, title):
    """Rows of a table of aligned columns that begins below the line with this title: label -> cells.

    The first row has the heads. Two spaces or more separate columns; the table ends at an empty line.
    """
    lines = text.splitlines()
    starts = [i for i, line in enumerate(lines) if line.startswith(title)]
    if not starts:
        raise ToolFailed("printed no table '%s'" % title)
    rows = {}
    for line in lines[starts[0] + 1:]:
        if not line.strip():
            break
        cells = re.split(r'\s{2,}', line.strip())
        rows.setdefault(cells[0], cells[1:])
    return rows


def find(rows, **values):
    """The row of a CSV with these values."""
    for row in rows:
        if all(row[name] == value for name, value in values.items()):
            return row
    raise ToolFailed('its figures have none with %s' % values)


@contextlib.contextmanager
def roscore(log):
    """A master of its own; gives the environment to run nodes in."""
    with socket.socket() as probe:
        probe.bind(('localhost', 0))
        port = probe.getsockname()[1]
    environment = dict(os.environ, ROS_MASTER_URI='http://localhost:%d' % port, ROS_HOSTNAME='localhost')
    environment.pop('ROS_IP', None)
    with open(log, 'w') as file:
        try:
            master = subprocess.Popen(['roscore', '-p', str(port)], env=environment, stdout=file,
                                      stderr=subprocess.STDOUT, start_new_session=True)
        except FileNotFoundError:
            raise ToolFailed('there is no roscore: source the workspace, e.g. build/devel/setup.bash')
        try:
            _wait_for_port(master, port, log)
            yield environment
        finally:
            if master.poll() is None:
                os.killpg(master.pid, signal.SIGINT)
                master.wait(20)


def _wait_for_port(master, port, log):
    for _ in range(300):
        if master.poll() is not None:
            break
        with contextlib.suppress(OSError), socket.create_connection(('localhost', port), 1):
            return
        time.sleep(0.1)
    raise ToolFailed('roscore did not start, see %s' % log)
