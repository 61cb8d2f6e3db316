#!/usr/bin/python3
"""Sizes that are too large, or contradict each other, are refused before memory is taken for them.

Arguments: a folder with the tools.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import rosbag

TOOLS = pathlib.Path(sys.argv[1])
MARGIN_MB = 60


def run(*command):
    """Exit status, output, peak of resident memory [MB]."""
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen([str(word) for word in command], stdout=output,
                                   stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.WEXITSTATUS(status) if os.WIFEXITED(status) else -os.WTERMSIG(status)
        output.seek(0)
        return process.returncode, output.read().decode(), usage.ru_maxrss / 1024


def set_fields(**values):
    def change(message):
        for name, value in values.items():
            setattr(message, name, value)
    return change


# What is changed in each image or camera_info, and the value that the message must name.
IMAGES = [
    (set_fields(width=2**31), '2147483648'),
    (set_fields(width=2**32 - 1), '4294967295'),
    (set_fields(height=2**31 - 1), '2147483647'),
    (set_fields(height=0), '248x0'),
    (set_fields(step=2**32 - 1), '4294967295'),
    (set_fields(step=1), 'step 1'),
    (set_fields(width=65535, height=65535, step=65535), '65535x65535'),
    (set_fields(width=2**31, step=2**31, height=2), '2147483648'),
    (set_fields(data=b''), '0 bytes'),
    (set_fields(data=bytes(100)), '100 bytes'),
]
INFOS = [
    (set_fields(width=2**31), '2147483648'),
    (set_fields(height=2**32 - 1), '4294967295'),
    (set_fields(width=0), '0x80'),
]
ASSIGNMENTS = [
    'disparity/matcher/range/count=2147483647',
    'disparity/matcher/range/count=1000000000',
    'disparity/matcher/range/min_disparity=-2147483648',
    'disparity/max_hole_px=99999999999',
    'disparity/points/stride=-2147483648',
    'disparity/queue_size=2147483647',
    'moving_objects/queue_size=2147483647',
]


class HostileSizes(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.bag = cls.folder / 'street.bag'
        status, output, _ = run(TOOLS / 'street_to_bag', cls.bag, '--frames', '4', '--size', '248x80')
        assert status == 0, output
        status, output, cls.usual_mb = run(*cls.replay(cls.bag))
        assert status == 0, output

    @classmethod
    def replay(cls, bag, *options):
        return [TOOLS / 'replay', '--bag', bag, '--output', cls.folder / 'out.bag', *options]

    def check(self, what, value, *commands):
        for command in commands:
            with self.subTest('%s: %s' % (command[0].name, what)):
                status, output, peak_mb = run(*command)
                self.assertIn(status, (0, 1, 2), output)
                self.assertIn(value, output)
                self.assertLess(peak_mb, self.usual_mb + MARGIN_MB, output)

    def test_of_images_and_calibrations(self):
        for kind, changes in (('sensor_msgs/Image', IMAGES), ('sensor_msgs/CameraInfo', INFOS)):
            for number, (change, value) in enumerate(changes):
                bag = self.folder / 'changed.bag'
                with rosbag.Bag(str(self.bag)) as source, rosbag.Bag(str(bag), 'w') as target:
                    for topic, message, stamp in source.read_messages():
                        if message._type == kind:
                            change(message)
                        target.write(topic, message, stamp)
                self.check('%s %d, %s' % (kind, number, value), value,
                           [TOOLS / 'check_bag', bag], self.replay(bag))

    def test_of_parameters(self):
        for assignment in ASSIGNMENTS:
            name, value = assignment.split('=')
            self.check(assignment, value, self.replay(self.bag, '--set', assignment))
            keys = name.split('/')
            yaml = self.folder / 'config.yaml'
            yaml.write_text(''.join('%s%s:\n' % ('  ' * i, key) for i, key in enumerate(keys[:-1])) +
                            '%s%s: %s\n' % ('  ' * (len(keys) - 1), keys[-1], value))
            self.check(yaml.read_text(), value, self.replay(self.bag, '--config', yaml))


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1] + sys.argv[2:], verbosity=2)
