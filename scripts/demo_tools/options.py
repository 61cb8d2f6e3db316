#!/usr/bin/python3
"""The options of scripts/demo. Needs nothing that is not built yet, so that wrong ones are told at once."""

import argparse
import os
import sys


def parse(arguments):
    parser = argparse.ArgumentParser(prog='scripts/demo', usage='see scripts/demo --help')
    source = parser.add_mutually_exclusive_group()
    source.add_argument('--kitti', nargs=2, metavar=('DATE_DIR', 'DRIVE'))
    source.add_argument('--bag')
    parser.add_argument('--camera', metavar='NS')
    parser.add_argument('--left', metavar='T')
    parser.add_argument('--right', metavar='T')
    parser.add_argument('--output', default='output')
    parser.add_argument('--rate', type=float)
    parser.add_argument('--frames', type=int, default=100)
    parser.add_argument('--cameras', choices=('gray', 'color'), default='gray')
    parser.add_argument('--config')
    parser.add_argument('--panels', type=int, default=60)
    parser.add_argument('--rviz', action='store_true')
    parser.add_argument('launch', nargs='*', metavar='name:=value')
    options = parser.parse_args(arguments)
    if options.bag and not os.path.isfile(options.bag):
        parser.error('--bag %s: there is no such file' % options.bag)
    if options.launch and not options.bag:
        parser.error('%s: launch arguments go with --bag' % options.launch[0])
    options.choice = [word for name in ('camera', 'left', 'right') if getattr(options, name)
                      for word in ('--' + name, getattr(options, name))]
    if options.choice and (not options.bag or options.launch and options.launch[0].endswith('.launch')):
        parser.error('%s: chooses topics of --bag, where no launch file is named' % options.choice[0])
    if options.rviz and not os.environ.get('DISPLAY'):
        parser.error('--rviz: there is no screen (DISPLAY is not set): scripts/rviz_screenshot takes a picture without')
    for name, smallest in (('frames', 2), ('panels', 1)):
        if getattr(options, name) < smallest:
            parser.error('--%s = %d: must be at least %d' % (name, getattr(options, name), smallest))
    if options.rate is not None and not 0 < options.rate <= 100:
        parser.error('--rate = %g: must be within (0, 100]' % options.rate)
    return options


if __name__ == '__main__':
    parse(sys.argv[1:])
