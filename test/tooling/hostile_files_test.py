#!/usr/bin/python3
"""Full and read-only disks, killed programs, and names that mean something to a shell.

Arguments: the repository, a folder with the tools. Exit status 77: no file system can be mounted.
"""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import cv2
import numpy as np

REPOSITORY, TOOLS = map(pathlib.Path, sys.argv[1:3])
SKIPPED = 77
DRIVE = '2011_09_26_drive_0001_sync'
# Quotes, blanks, dots, and what a shell would run.
HOSTILE = """a 'b' "c" <i> $(touch hacked) `touch hacked`;touch hacked .."""

CAMERA = """S_rect_0{0}: 640 200
K_0{0}: 500 0 320 0 500 100 0 0 1
D_0{0}: 0 0 0 0 0
R_rect_0{0}: 1 0 0 0 1 0 0 0 1
P_rect_0{0}: 500 0 320 {1} 0 500 100 0 0 0 1 0
"""


def write_drive(folder, frames=3):
    """A drive of KITTI's raw recordings, as large as need be: noise, and scans of a wall."""
    noise = np.random.RandomState(1)
    (folder / 'calib_cam_to_cam.txt').parent.mkdir(parents=True)
    (folder / 'calib_cam_to_cam.txt').write_text(CAMERA.format(0, 0) + CAMERA.format(1, -250))
    for name in 'calib_velo_to_cam.txt', 'calib_imu_to_velo.txt':
        (folder / name).write_text('R: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 0\n')
    stamps = ''.join('2011-09-26 13:02:%02d.000000000\n' % i for i in range(frames))
    for kind in 'image_00', 'image_01', 'velodyne_points':
        (folder / DRIVE / kind / 'data').mkdir(parents=True)
        (folder / DRIVE / kind / 'timestamps.txt').write_text(stamps)
    left = noise.randint(0, 256, (200, 640)).astype(np.uint8)
    for i in range(frames):
        for kind, image in (('image_00', left), ('image_01', np.roll(left, -25, 1))):
            cv2.imwrite(str(folder / DRIVE / kind / 'data' / ('%010d.png' % i)), image)
        y, z = np.meshgrid(np.arange(-3, 3, .1), np.arange(-1, 1, .1))
        points = np.stack([np.full(y.shape, 10.), y, z, np.ones(y.shape)], -1)
        points.astype(np.float32).tofile(
            folder / DRIVE / 'velodyne_points' / 'data' / ('%010d.bin' % i))


def run(command, **options):
    return subprocess.run([str(word) for word in command], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, universal_newlines=True, **options)


class HostileFiles(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.bag = cls.folder / 'street.bag'
        made = run([TOOLS / 'street_to_bag', cls.bag, '--frames', '6', '--size', '496x160'])
        assert made.returncode == 0, made.stdout
        cls.day = cls.folder / 'day'
        write_drive(cls.day)
        cls.disk = cls.folder / 'disk'
        cls.disk.mkdir()

    def mount(self, options):
        subprocess.run(['mount', '-t', 'tmpfs', '-o', options, 'tmpfs', self.disk], check=True)
        self.addCleanup(subprocess.run, ['umount', '-l', self.disk], check=True)

    def writers(self):
        """Commands that write into the folder of the disk."""
        street = ['--street', 'straight', '--street-frames', '3']
        out = self.disk / 'out'
        return [
            ['street_to_bag', self.disk / 'new.bag', '--frames', '6', '--size', '496x160'],
            ['replay', '--bag', self.bag, '--output', self.disk / 'out.bag'],
            ['replay', '--bag', self.bag, '--output', self.disk / 'out.bag', '--compress'],
            ['replay', '--bag', self.bag, '--output', self.folder / 'kept.bag', '--topics', 'odometry',
             '--csv', out / 'a.csv'],
            ['kitti_to_bag', self.day, DRIVE, self.disk / 'drive.bag'],
            ['estimate_noise', self.day, DRIVE, '--output', out],
            ['evaluate_odometry', *street, '--csv', out / 'a.csv'],
            ['evaluate_odometry', *street, '--report', out],
            ['evaluate_kitti', *street, '--methods', 'ours', '--csv', out / 'a.csv'],
            ['evaluate_kitti', *street, '--methods', 'ours', '--report', out],
            ['evaluate_detection', *street, '--csv', out / 'a.csv'],
            ['evaluate_detection', *street, '--report', out],
        ]

    def files(self):
        return sorted(str(path.relative_to(self.disk)) for path in self.disk.rglob('*')
                      if path.is_file())

    def test_a_full_disk_is_named_and_keeps_nothing_partial(self):
        self.mount_full(0)
        self.check_full(self.writers())

    def test_a_disk_that_fills_up_is_named_and_keeps_nothing_partial(self):
        self.mount_full(200000)
        self.check_full([command for command in self.writers() if 'bag' in command[0] or
                         command[0] == 'replay' and '--csv' not in command])

    def mount_full(self, left):
        self.mount('size=800k')
        (self.disk / 'other').write_bytes(bytes(800 * 1024 - left))

    def check_full(self, commands):
        for command in commands:
            with self.subTest(' '.join(map(str, command[:3]))):
                result = run([TOOLS / command[0], *command[1:]])
                self.assertEqual(result.returncode, 1, result.stdout)
                self.assertIn('cannot be written', result.stdout)
                self.assertRegex(result.stdout, 'the disk is full|No space left on device')
                self.assertEqual(self.files(), ['other'])
                shutil.rmtree(self.disk / 'out', ignore_errors=True)

    def test_a_disk_that_cannot_be_written_is_named(self):
        self.mount('size=1m')
        subprocess.run(['mount', '-o', 'remount,ro', self.disk], check=True)
        for command in self.writers():
            with self.subTest(' '.join(map(str, command[:3]))):
                result = run([TOOLS / command[0], *command[1:]])
                self.assertEqual(result.returncode, 1, result.stdout)
                self.assertIn(str(self.disk), result.stdout)
                self.assertIn('annot be written', result.stdout)

    def test_scripts_name_it_too(self):
        self.mount_full(0)
        many = run([REPOSITORY / 'scripts/evaluate_many', self.list_of(self.bag), '--cores', '1',
                    '--tools', TOOLS, '--output', self.disk / 'many'])
        if shutil.which('snakemake'):
            self.assertNotEqual(many.returncode, 0, many.stdout)
            self.assertNotIn('Traceback', many.stdout.replace('  Traceback', ''))
        environment = dict(os.environ, PATH='%s:%s' % (TOOLS, os.environ['PATH']))
        demo = [REPOSITORY / 'scripts/demo_tools/run.py', '--frames', '3', '--output']
        full = run(demo + [self.disk / 'demo'], env=environment)
        self.assertEqual(full.returncode, 1, full.stdout)
        self.assertIn('the disk is full', full.stdout)
        report = self.folder / 'report'
        run([TOOLS / 'evaluate_detection', self.bag, '--report', report], check=True)
        (self.disk / 'pictures').mkdir()
        (report / 'pictures').symlink_to(self.disk / 'pictures')
        page = run([REPOSITORY / 'scripts/report', report])
        self.assertEqual(page.returncode, 1, page.stdout)
        self.assertIn('cannot be written: is the disk full?', page.stdout)
        self.assertEqual(self.files(), ['other'])
        subprocess.run(['mount', '-o', 'remount,ro', self.disk], check=True)
        read_only = run(demo + [self.disk / 'demo2'], env=environment)
        self.assertEqual(read_only.returncode, 1, read_only.stdout)
        self.assertIn('cannot be written: Read-only file system', read_only.stdout)
        if shutil.which('Xvfb'):
            picture = run([REPOSITORY / 'scripts/rviz_screenshot', self.disk / 'a.png', 'demo_street.launch',
                           'bag:=%s' % self.bag], env=environment)
            self.assertEqual(picture.returncode, 1, picture.stdout)
            self.assertIn('rviz_screenshot: [Errno 30] Read-only file system', picture.stdout)

    def test_text_that_is_lost_is_an_error(self):
        for command in (['replay', '--parameters'], ['check_bag', '--launch', self.bag], ['kitti_to_bag', '--help']):
            with self.subTest(command[0]), open('/dev/full', 'w') as full:
                result = subprocess.run([str(word) for word in [TOOLS / command[0], *command[1:]]], stdout=full,
                                        stderr=subprocess.PIPE, text=True)
                self.assertEqual(result.returncode, 1)
                self.assertIn('standard output cannot be written', result.stderr)

    def list_of(self, *bags):
        path = self.folder / 'list'
        path.write_text(''.join('%s\n' % bag for bag in bags))
        return path

    def test_killed_programs_leave_nothing_that_looks_whole(self):
        folder = self.folder / 'killed'
        for how, left in ((signal.SIGTERM, 0), (signal.SIGINT, 0), (signal.SIGHUP, 0), (signal.SIGKILL, 1)):
            for command in (
                    ['street_to_bag', folder / 'a.bag', '--frames', '200', '--size', '496x160'],
                    ['replay', '--bag', self.long_bag(), '--output', folder / 'a.bag'],
                    ['kitti_to_bag', self.long_drive(), DRIVE, folder / 'a.bag']):
                with self.subTest('%s %s' % (command[0], how)):
                    shutil.rmtree(folder, ignore_errors=True)
                    folder.mkdir()
                    process = subprocess.Popen([str(word) for word in [TOOLS / command[0], *command[1:]]],
                                               stderr=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                               preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
                    while process.poll() is None and not any(
                            file.stat().st_size > 50000 for file in folder.iterdir()):
                        time.sleep(0.01)
                    process.send_signal(how)
                    errors = process.communicate()[1].decode()
                    self.assertNotEqual(process.returncode, 0, 'it was done before')
                    names = [file.name for file in folder.iterdir()]
                    self.assertNotIn('a.bag', names)
                    self.assertEqual(len(names), left, names)
                    if how != signal.SIGKILL:
                        self.assertEqual(process.returncode, 1)
                        self.assertIn('interrupted', errors)

    def test_nohup_goes_on_without_its_terminal(self):
        process = subprocess.Popen([str(TOOLS / 'street_to_bag'), str(self.folder / 'nohup.bag'), '--frames', '200'],
                                   stderr=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                   preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        time.sleep(1)
        process.send_signal(signal.SIGHUP)
        time.sleep(1)
        self.assertIsNone(process.poll())
        process.terminate()
        self.assertIn('interrupted', process.communicate()[1].decode())

    def long_bag(self):
        path = self.folder / 'long.bag'
        if not path.exists():
            run([TOOLS / 'street_to_bag', path, '--frames', '60', '--size', '496x160'], check=True)
        return path

    def long_drive(self):
        path = self.folder / 'long'
        if not path.exists():
            write_drive(path, 60)
        return path

    def test_names_are_names_and_nothing_else(self):
        folder = self.folder / HOSTILE
        folder.mkdir()
        bag = folder / (HOSTILE + '.bag')
        shutil.copy(self.bag, bag)
        here = folder / 'here'
        here.mkdir()
        checked = run([TOOLS / 'check_bag', bag], cwd=here)
        self.assertEqual(checked.returncode, 0, checked.stdout)
        # What it prints is copied into a shell.
        line = next(line for line in checked.stdout.splitlines() if ' roslaunch ' in line)
        words = run(['bash', '-c', "printf '%s\\n' " + line], cwd=here).stdout.splitlines()
        self.assertIn('bag:=%s' % bag, words)
        for command in (
                ['replay', '--bag', bag, '--output', folder / 'x;y $(z).bag', '--topics', 'odometry'],
                ['evaluate_detection', bag, '--frames', '3', '--report', folder / 'report'],
                ['street_to_bag', folder / '$(touch hacked).bag', '--frames', '2', '--size', '248x80']):
            result = run([TOOLS / command[0], *command[1:]], cwd=here)
            self.assertEqual(result.returncode, 0, result.stdout)
        self.assertTrue((folder / 'x;y $(z).bag').is_file())
        pictures = list((folder / 'report' / 'frames').iterdir())
        self.assertEqual(len(pictures), 3, pictures)
        for picture in pictures:
            self.assertRegex(picture.name, '^[A-Za-z0-9_.]+$')
        self.assertEqual(run([REPOSITORY / 'scripts/report', folder / 'report']).returncode, 0)
        self.assertNotIn('<i>', (folder / 'report' / 'index.html').read_text())
        self.assertEqual(list(self.folder.rglob('hacked')), [])

    def test_nothing_leaves_the_output_folder(self):
        out = self.folder / 'inside' / 'out'
        inside = str(self.day / DRIVE)
        escape = os.path.join('..', 'day', DRIVE)  # a drive whose name climbs
        result = run([TOOLS / 'estimate_noise', self.day, escape, '--output', out])
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertEqual([path.name for path in out.parent.iterdir()], ['out'])
        self.assertEqual(len(list(out.glob('*_process_error.png'))), 1)
        self.assertEqual(sorted(os.listdir(inside)), ['image_00', 'image_01', 'velodyne_points'])


def can_mount():
    with tempfile.TemporaryDirectory() as folder:
        mounted = subprocess.run(['mount', '-t', 'tmpfs', '-o', 'size=64k', 'tmpfs', folder],
                                 stderr=subprocess.DEVNULL)
        if mounted.returncode == 0:
            subprocess.run(['umount', folder], check=True)
        return mounted.returncode == 0


if __name__ == '__main__':
    if not can_mount():
        print('skipped: needs to mount a small tmpfs, as root')
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
