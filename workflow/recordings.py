"""The list of recordings that evaluate_many takes, and what is measured of each."""

import glob
import os
import re
import shlex

OPTIONS = ('name', 'camera', 'left', 'right', 'labels', 'rectify')
# Measurements, by the program that makes them.
TOOLS = {'replay': 'replay', 'detection': 'evaluate_detection', 'disparity': 'evaluate_kitti',
         'odometry': 'evaluate_odometry'}


class ListError(Exception):
    """An error in the list, and its place."""


class Recording:
    """A bag, or a drive of KITTI's raw recordings: `paths` is (BAG,) or (DATE_DIR, DRIVE)."""

    def __init__(self, name, paths, options):
        self.name, self.paths, self.options = name, paths, options
        self.is_bag = len(paths) == 1
        self.path = os.path.join(*paths)

    def measurements(self):
        """The measurements that are possible. Of a missing recording: all that its kind has."""
        if self.is_bag:
            return ['replay'] + (['detection'] if self.options.get('labels') else [])
        found = []
        if not os.path.isdir(self.path) or os.path.isdir(self.path + '/velodyne_points'):
            found.append('disparity')
        if os.path.isdir(self.path + '/oxts') or os.path.isfile(self.path + '/poses_gt_cam0.txt'):
            found.append('odometry')
        if self.options.get('labels'):
            found.append('detection')
        return found

    def inputs(self):
        """Files and folders whose change makes old figures invalid."""
        files = [self.path]
        if not self.is_bag:
            files += [self.paths[0] + '/calib_cam_to_cam.txt', self.path + '/poses_gt_cam0.txt']
            files += ['%s/image_0%d/data' % (self.path, camera) for camera in (0, 1)]
        if self.options.get('labels', 'own') != 'own':
            files.append(self.options['labels'])
        return [file for file in files if os.path.exists(file)]

    def megabytes(self):
        if self.is_bag:
            return os.path.getsize(self.path) / 1e6 if os.path.isfile(self.path) else 0
        return sum(map(os.path.getsize, glob.iglob(glob.escape(self.path) + '/image_0[01]/data/*'))) / 1e6

    def command(self, measurement, tools, csv, threads, arguments, bag):
        """The program and its arguments, a list: no shell reads it.

        @param bag  replay's outputs go there.
        """
        options = self.options
        command = [os.path.join(tools, TOOLS[measurement])]
        if measurement == 'replay':
            command += ['--bag', self.path, '--output', bag, '--topics', 'odometry,moving_objects']
        else:
            command += list(self.paths)
        if self.is_bag:
            for key in ('camera', 'left', 'right'):
                if options.get(key):
                    command += ['--' + key, options[key]]
        if measurement == 'replay' and options.get('rectify') == 'true':
            command.append('--rectify')
        if measurement == 'detection' and options['labels'] != 'own':
            command += ['--labels', options['labels']]
        if measurement == 'disparity':
            command += ['--methods', 'ours']
        return command + ['--csv', csv, '--threads', str(threads)] + arguments


def safe_name(text, taken):
    """A valid file name: only letters, digits, underscores and dashes."""
    name = re.sub('[^A-Za-z0-9_-]+', '_', text).strip('_') or 'recording'
    number, unique = 1, name
    while unique in taken:
        number += 1
        unique = '%s_%d' % (name, number)
    return unique


def read_list(path, labels=None):
    """Recordings by name.

    Each line is BAG or DATE_DIR DRIVE, then key=value of OPTIONS; quotes and # as in a shell.
    Relative paths start at the list's folder.
    @param labels  a folder with NAME.csv: the labels of drive or bag NAME.
    """
    folder = os.path.dirname(os.path.abspath(path))
    try:
        with open(path, encoding='utf-8') as file:
            lines = file.read().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ListError('%s: cannot be read: %s' % (path, error)) from None
    recordings = {}
    for number, line in enumerate(lines, 1):
        where = '%s:%d: ' % (path, number)
        try:
            words = shlex.split(line, comments=True)
        except ValueError as error:
            raise ListError(where + '%s: %s' % (error, line)) from None
        if not words:
            continue
        paths, options = [], {}
        for word in words:
            key, equals, value = word.partition('=')
            if equals and key in OPTIONS:
                options[key] = value
            elif options:
                raise ListError(where + 'what is "%s"? There are %s' %
                                (word, ', '.join(key + '=' for key in OPTIONS)))
            else:
                paths.append(word)
        if len(paths) not in (1, 2) or not all(paths):
            raise ListError(where + 'expected BAG or DATE_DIR DRIVE, found %d words' % len(paths))
        if len(paths) == 1 and os.path.isdir(os.path.join(folder, paths[0])):
            raise ListError(where + '%s is a folder: expected BAG, or DATE_DIR DRIVE' % paths[0])
        if any(path.startswith('-') for path in paths):
            raise ListError(where + '"%s" is no recording: begin it with ./' % line)
        paths[0] = os.path.join(folder, paths[0])
        own = os.path.basename(paths[-1].rstrip('/'))
        own = own[:-4] if own.endswith('.bag') else own
        if options.get('labels', 'own') != 'own':
            options['labels'] = os.path.join(folder, options['labels'])
        elif labels and 'labels' not in options and os.path.isfile(os.path.join(labels, own + '.csv')):
            options['labels'] = os.path.abspath(os.path.join(labels, own + '.csv'))
        name = safe_name(options.get('name', own), recordings)
        recordings[name] = Recording(name, tuple(paths), options)
        if not recordings[name].measurements():
            raise ListError(where + '%s has neither velodyne_points nor oxts nor labels: nothing to '
                            'measure against' % recordings[name].path)
    if not recordings:
        raise ListError(path + ': names no recordings')
    return recordings
