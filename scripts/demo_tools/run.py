#!/usr/bin/python3
"""Plays a bag into the nodelets and writes pictures and a report. Started by scripts/demo."""

import math
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import launching
import options as command_line
import panels
import recording
import report

COMPLETE = 0.95  # share of the pairs that must have come out, or the bag is played again slower
SLOWEST_RATE = 0.1


class DemoError(Exception):
    """Ends the demo with a message."""


def tool(name, *arguments):
    """Runs a tool of this package; its errors are on the screen already when it fails."""
    status = subprocess.call([name] + list(arguments))
    if status:
        raise DemoError('%s failed (exit status %d)' % (name, status))


def say(text):
    print('\n== ' + text, flush=True)


def prepare(options, output, work):
    """Makes or finds the bag; returns (title, bag, launch file, launch arguments)."""
    if options.bag:
        bag = os.path.abspath(options.bag)
        if options.launch and options.launch[0].endswith('.launch'):
            line = options.launch
        else:
            say('Checking %s' % options.bag)
            found = subprocess.run(
                ['check_bag', '--launch', bag, *options.choice], stdout=subprocess.PIPE, universal_newlines=True,
                check=False)
            if found.returncode:
                raise DemoError('the bag cannot be used as it is')
            line = shlex.split(found.stdout) + options.launch  # the later of two arguments holds
        return os.path.basename(bag), bag, line[0], line[1:]
    if options.kitti:
        folder, drive = options.kitti
        bag = os.path.join(output, os.path.basename(os.path.normpath(drive)) + '.bag')
        say('Converting %s' % drive)
        made = os.path.join(work, 'made.bag')
        tool('kitti_to_bag', folder, drive, made, '--cameras', options.cameras)
        os.replace(made, bag)
        return 'KITTI ' + drive, bag, 'kitti.launch', ['cameras:=' + options.cameras]
    bag = os.path.join(output, 'street.bag')
    say('Rendering %d frames of a synthetic street' % options.frames)
    made = os.path.join(work, 'made.bag')
    tool('street_to_bag', made, '--frames', str(options.frames))
    os.replace(made, bag)
    return 'Synthetic street', bag, 'demo_street.launch', []


def plainly_named(bag, work):
    """A name without what roslaunch takes for its own: a link to the bag where it has such a one."""
    if not re.search(r"['\"\\$]", bag):
        return bag
    link = os.path.join(work, 'recording.bag')
    os.symlink(bag, link)
    return link


def play(options, bag, launch_file, launch_arguments, work):
    """Plays the bag, slower again where frames were lost; returns (recording, rate)."""
    camera, images = launching.topics(launch_file, launch_arguments)
    pairs = recording.count_pairs(bag, images)
    if pairs == 0:
        raise DemoError('%s has no pairs on %s and %s' % (bag, *images))
    rate = options.rate or 1.0
    while True:
        say('Playing %d pairs at %gx into %s' % (pairs, rate, launch_file))
        frames = os.path.join(work, 'frames')
        shutil.rmtree(frames, ignore_errors=True)
        os.makedirs(frames)
        with launching.Launch(launch_file, launch_arguments + [
                'bag:=' + bag, 'rate:=%g' % rate, 'play_options:=--pause',
                'rviz:=' + str(options.rviz).lower()], os.path.join(work, 'log')) as launch:
            result = recording.record(launch, camera, frames, pairs, options.panels)
        print('%d of %d pairs came out with all outputs (%d are enough)' %
              (result.complete, pairs, math.ceil(COMPLETE * pairs)), flush=True)
        if result.complete == 0:
            raise DemoError('the nodelets gave no outputs. The end of their log:\n' + launch.tail())
        if result.complete >= COMPLETE * pairs:
            return result, rate
        if options.rate or rate / 2 < SLOWEST_RATE:
            raise DemoError('only %d of %d pairs came out at %gx' % (result.complete, pairs, rate))
        rate /= 2
        print('This machine is too slow for that, or busy: once more, slower')


def main():
    options = command_line.parse(sys.argv[1:])
    output = os.path.abspath(options.output)
    started = time.time()
    # So that roslaunch ends and the working folder goes.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    try:
        os.makedirs(output, exist_ok=True)
        work = tempfile.mkdtemp(prefix='.demo_', dir=output)
    except OSError as error:
        print('demo: --output %s: cannot be written: %s' % (options.output, error.strerror),
              file=sys.stderr)
        return 1
    try:
        title, bag, launch_file, launch_arguments = prepare(options, output, work)
        if options.config:
            launch_arguments.append('config:=' + os.path.abspath(options.config))
        result, rate = play(options, plainly_named(bag, work), launch_file, launch_arguments, work)
        say('Drawing %d frames' % len(result.frames))
        pictures, drawing = os.path.join(output, 'panels'), os.path.join(work, 'panels')
        os.makedirs(drawing)
        drawn = panels.draw_all(result, bag, drawing)
        page = os.path.join(output, 'report.html')
        written = os.path.join(work, 'report.html')
        report.write(written, report.Run(title=title, bag=bag, rate=rate, launch_file=launch_file,
                                         recording=result, drawn=drawn))
        shutil.rmtree(pictures, ignore_errors=True)
        os.replace(drawing, pictures)
        os.replace(written, page)
        say('Done in %.0f s' % (time.time() - started))
        print('Pictures: %s\nReport:   %s\nBag:      %s' % (pictures, page, bag))
        return 0
    except KeyboardInterrupt:
        print('demo: interrupted', file=sys.stderr)
        return 1
    except (DemoError, launching.LaunchError, OSError) as error:
        print('demo: %s' % error, file=sys.stderr)
        log = os.path.join(work, 'log')
        if os.path.isdir(log):
            kept = os.path.join(output, 'log')
            shutil.rmtree(kept, ignore_errors=True)
            shutil.move(log, kept)
            print('Logs: %s' % kept, file=sys.stderr)
        return 1
    finally:
        shutil.rmtree(work, ignore_errors=True)


if __name__ == '__main__':
    sys.exit(main())
