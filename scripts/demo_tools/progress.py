"""A bar on stderr where that is a terminal, nothing where it is a file; as the tools' own."""

import sys
import time

BAR = 20  # characters


def clock(seconds):
    minutes, seconds = divmod(int(round(seconds)), 60)
    return '%d:%02d' % (minutes, seconds)


class Progress:
    """Use it as a context: the line ends with it."""

    def __init__(self, what, total):
        self.what, self.total = what, max(1, total)
        self.shown = sys.stderr.isatty()
        self.begin = time.monotonic()
        self.line_open = False

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.line_open:
            print(file=sys.stderr)

    def update(self, done):
        if not self.shown:
            return
        done = min(done, self.total)
        full = BAR * done // self.total
        elapsed = time.monotonic() - self.begin
        text = '%s  [%s%s]  %3d %%  %d of %d' % (self.what, '#' * full, '.' * (BAR - full),
                                                100 * done // self.total, done, self.total)
        if done == self.total:
            text += '  in ' + clock(elapsed)
        elif done and elapsed >= 1:
            text += '  %s left' % clock(elapsed * (self.total - done) / done)
        # The escape clears what a longer line has left behind.
        print('\r' + text + '\033[K', end='', file=sys.stderr, flush=True)
        self.line_open = True
