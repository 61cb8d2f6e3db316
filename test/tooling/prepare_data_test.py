#!/usr/bin/python3
"""scripts/prepare_data: excerpts of KITTI in the disguise of the downloads, and made-up downloads.

Argument: the repository. KITTI_EXCERPTS names the excerpts; without it their test is skipped.
"""

import filecmp
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
import numpy

REPOSITORY = pathlib.Path(sys.argv[1])
SCRIPT = REPOSITORY / 'scripts/prepare_data'
EXCERPTS = os.environ.get('KITTI_EXCERPTS')
DAY = '2011_09_26'
# The cameras of EuRoC's V1_01_easy, as its sensor.yaml have them.
CAMERAS = [
    ('458.654, 457.296, 367.215, 248.375', '-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05',
     """0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,
         0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,
        -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,"""),
    ('457.587, 456.134, 379.999, 255.238', '-0.28368365,  0.07451284, -0.00010473, -3.55590700e-05',
     """0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,
         0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024,
        -0.0253898008918, 0.0179005838253, 0.999517347078, 0.00786212447038,""")]
EUROC_START_NS = 1403715273262142976


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def write_image(path, image):
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), image, [cv2.IMWRITE_PNG_COMPRESSION, 0])


def files_below(folder):
    return {str(path.relative_to(folder)) for path in pathlib.Path(folder).glob('**/*') if path.is_file()}


def link(path, target):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.symlink_to(target)


class Disguise:
    """The public downloads, as far as the excerpts have them."""

    def __init__(self, excerpts, root):
        self.excerpts, self.root = pathlib.Path(excerpts), root
        for name in ('cam_to_cam', 'velo_to_cam', 'imu_to_velo'):
            link(root / DAY / ('calib_%s.txt' % name), self.excerpts / DAY / ('calib_%s.txt' % name))
        for drive, first in ((1, 40), (2, 0), (9, 0), (13, 0)):
            self.raw_drive('%s/%s_drive_%04d_sync' % (DAY, DAY, drive), first)
        self.odometry()
        self.stereo_2012()
        self.stereo_2015()

    def raw_drive(self, drive, first):
        for file in sorted((self.excerpts / drive).glob('**/*.*')):
            target = self.root / file.relative_to(self.excerpts)
            if file.parent.name == 'data':
                link(target.with_name('%010d%s' % (int(file.stem) + first, file.suffix)), file)
            elif 'timestamps' in file.name:
                other = '1970-01-01 00:00:00.0\n'
                write(target, other * first + file.read_text() + other)
            elif file.is_file():
                link(target, file)

    def odometry(self):
        day = self.excerpts / '2011_09_30'
        drive = day / '2011_09_30_drive_0020_sync'
        root = self.root / 'dataset'
        for camera in range(2):
            for file in (drive / ('image_%02d/data' % camera)).iterdir():
                link(root / ('sequences/06/image_%d/%06d.png' % (camera, int(file.stem))), file)
        calibration = (day / 'calib_cam_to_cam.txt').read_text().splitlines()
        lines = [line.replace('_rect_0', '') for line in calibration if line.startswith('P_rect_0')]
        write(root / 'sequences/06/calib.txt', '\n'.join(lines) + '\nP2: 0\n')
        stamps = (drive / 'image_00/timestamps.txt').read_text().splitlines()
        write(root / 'sequences/06/times.txt',
              ''.join('%.6e\n' % float(line.rpartition(':')[2]) for line in stamps + ['0:99']))
        poses = [line.split() for line in (drive / 'poses_gt_cam0.txt').read_text().splitlines()]
        write(root / 'poses/06.txt', '\n'.join(' '.join('%.6e' % float(word) for word in line)
                                              for line in poses + poses[:1]) + '\n')

    def stereo_2012(self):
        source = self.excerpts / 'stereo_flow_2012/training'
        for file in source.glob('image_*/*'):
            extension = not file.stem.endswith(('_10', '_11'))
            folder = 'data_stereo_flow_multiview' if extension else 'data_stereo_flow'
            link(self.root / folder / 'training' / file.relative_to(source), file)
        for file in list(source.glob('disp_*/*')) + list(source.glob('flow_*/*')):
            link(self.root / 'data_stereo_flow/training' / file.relative_to(source), file)
        for file in source.glob('calib/*'):
            write(self.root / 'data_stereo_flow/training/calib' / file.name,
                  file.read_text() + 'P2: 0\nP3: 0\n')

    def stereo_2015(self):
        source = self.excerpts / 'scene_flow_2015/training'
        for file in source.glob('*/*'):
            target = self.root / 'data_scene_flow/training' / file.relative_to(source)
            if file.parent.name.startswith('image_'):
                write_image(target, cv2.imread(str(file), cv2.IMREAD_COLOR))
            else:
                link(target, file)


def made_up_0013(root):
    drive = root / DAY / (DAY + '_drive_0013_sync')
    for name in ('cam_to_cam', 'velo_to_cam', 'imu_to_velo'):
        write(root / DAY / ('calib_%s.txt' % name), 'S_00: 4 3\n')
    for camera in ('image_00', 'image_01'):
        for frame in range(16):
            write_image(drive / camera / ('data/%010d.png' % frame), numpy.full((3, 4), frame, numpy.uint8))
        write(drive / camera / 'timestamps.txt', '2011-09-26 13:10:51.1\n' * 20)
    return drive


def made_up_euroc(root):
    for camera, (intrinsics, distortion, pose) in enumerate(CAMERAS):
        folder = root / ('V1_01_easy/mav0/cam%d' % camera)
        write(folder / 'sensor.yaml', 'T_BS:\n  cols: 4\n  data: [%s\n    0.0, 0.0, 0.0, 1.0]\n'
              'resolution: [752, 480]\nintrinsics: [%s] #fu, fv, cu, cv\ndistortion_coefficients: [%s]\n' %
              (pose, intrinsics, distortion))
        stamps = [EUROC_START_NS + 50000000 * frame for frame in range(61)]
        write(folder / 'data.csv', '#timestamp [ns],filename\r\n' +
              ''.join('%d,%d.png\r\n' % (stamp, stamp) for stamp in stamps))
        grey = folder / 'grey.png'
        write_image(grey, numpy.full((480, 752), 100, numpy.uint8))
        (folder / 'data').mkdir()
        for stamp in stamps:
            link(folder / ('data/%d.png' % stamp), grey)


class PrepareData(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix='prepare_data_test_'))
        self.addCleanup(shutil.rmtree, self.folder)
        self.root = self.folder / 'downloads'
        self.root.mkdir()
        self.out = self.folder / 'out'

    def prepare(self, *arguments):
        return subprocess.run([SCRIPT, self.root, self.out, *arguments], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, universal_newlines=True, check=False)

    def assert_refused(self, result, status, *texts):
        self.assertEqual(result.returncode, status, result.stdout)
        for text in texts:
            self.assertIn(text, result.stdout)
        self.assertEqual([path.name for path in self.folder.iterdir()], ['downloads'], 'something was left')

    @unittest.skipUnless(EXCERPTS, 'KITTI_EXCERPTS is not set')
    def test_disguised_excerpts_become_the_excerpts(self):
        Disguise(EXCERPTS, self.root)
        result = self.prepare()
        self.assertEqual(result.returncode, 0, result.stdout)
        made = files_below(self.out)
        for name in sorted(made):
            if name.startswith('labels/'):
                continue
            one, other = self.out / name, pathlib.Path(EXCERPTS, name)
            if name.startswith('scene_flow_2015') and '/image_' in name:
                same = numpy.array_equal(cv2.imread(str(one), -1), cv2.imread(str(other), -1))
            elif 'timestamps' in name:  # excerpts with laser scans have the stamps of the whole drive
                same = other.read_text().startswith(one.read_text())
            else:
                same = filecmp.cmp(one, other, shallow=False)
            self.assertTrue(same, name)
        # The excerpts have GPS of the whole drive 0009.
        gps = DAY + '/' + DAY + '_drive_0009_sync/oxts/data/'
        further = {name for name in files_below(EXCERPTS) - made if not name.startswith(gps)}
        self.assertLessEqual({name.split('/')[0] for name in further}, {'SOURCE.md', 'labels', 'tracking'})
        shipped = {'labels/' + path.name for path in (REPOSITORY / 'test/data/labels').glob('*.csv')}
        self.assertGreaterEqual(made, shipped)

    def test_missing_downloads_are_named(self):
        self.assert_refused(
            self.prepare(), 2, 'missing below %s' % self.root,
            DAY + '_drive_0009_sync/oxts/dataformat.txt and ',
            '"synced+rectified data" of 2011_09_26_drive_0009 from '
            'https://www.cvlibs.net/datasets/kitti/raw_data.php',
            'odometry data set', 'stereo 2012', 'stereo 2015', '--only SET')
        drive = made_up_0013(self.root)
        (drive / 'image_01/data/0000000007.png').unlink()
        result = self.prepare('--only', '0013')
        self.assert_refused(result, 2, DAY + '_drive_0013_sync/image_01/data/0000000007.png: download ')
        self.assertNotIn('more files', result.stdout)
        self.assert_refused(self.prepare('--only', 'euroc'), 2, 'V1_01_easy of the EuRoC MAV data set')

    def test_other_data_is_named_by_its_checksum(self):
        made_up_0013(self.root)
        result = self.prepare('--only', '0013')
        images = '%s/%s_drive_0013_sync/image_00/data' % (DAY, DAY)
        self.assert_refused(result, 1, 'checksum differs: %s: its first file' % images, 'nothing was written')
        self.assertNotIn('drive_0009', result.stdout)
        result = self.prepare('--only', '0013', '--accept-differences')
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertIn('checksum differs', result.stdout)
        drive = self.out / DAY / (DAY + '_drive_0013_sync')
        self.assertEqual(len(list((drive / 'image_01/data').iterdir())), 16)
        self.assertEqual(len((drive / 'image_01/timestamps.txt').read_text().splitlines()), 16)

    def test_wrong_use(self):
        result = self.prepare('--only', '13')
        self.assert_refused(result, 2, '--only 13: there is no such set; there are 0001, ')
        self.out.mkdir()
        result = self.prepare()
        self.assertEqual(result.returncode, 2)
        self.assertIn('%s: exists already; remove it' % self.out, result.stdout)
        self.out.rmdir()
        self.root.rmdir()
        result = self.prepare()
        self.assertEqual(result.returncode, 2)
        self.assertIn('KITTI_ROOT %s: is no folder' % self.root, result.stdout)

    def test_broken_files_leave_nothing_behind(self):
        drive = made_up_0013(self.root)
        stamps = drive / 'image_01/timestamps.txt'
        stamps.write_text('2011-09-26 13:10:51.1\n' * 3)
        self.assert_refused(self.prepare('--only', '0013'), 1, '%s: has 3 lines, lines 1 to 16' % stamps)
        made_up_euroc(self.root)
        image = self.root / ('V1_01_easy/mav0/cam1/data/%d.png' % EUROC_START_NS)
        whole = image.read_bytes()
        image.unlink()
        image.write_bytes(whole[:20])
        self.assert_refused(self.prepare('--only', 'euroc'), 1, '%s: cannot be read as an image' % image)
        write_image(image, numpy.zeros((3, 4), numpy.uint8))
        self.assert_refused(self.prepare('--only', 'euroc'), 1, 'has 4x3 pixels instead of 752x480')

    def test_an_interruption_leaves_nothing_behind(self):
        made_up_euroc(self.root)
        command = [SCRIPT, self.root, self.out, '--only', 'euroc']
        with subprocess.Popen(command, stderr=subprocess.DEVNULL) as process:
            while not list(self.folder.glob('.prepare_data_*/2014_06_25/*/image_00/data/*5.png')):
                self.assertIsNone(process.poll())
                time.sleep(0.005)
            process.send_signal(signal.SIGTERM)
        self.assertEqual(process.returncode, 130)
        self.assertEqual([path.name for path in self.folder.iterdir()], ['downloads'])

    def test_euroc_is_rectified(self):
        made_up_euroc(self.root)
        result = self.prepare('--only', 'euroc', '--accept-differences')
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertNotIn('calib_cam_to_cam', result.stdout, 'another calibration than that of the figures')
        day = self.out / '2014_06_25'
        self.assertIn('P_rect_01: 4.362345864', (day / 'calib_cam_to_cam.txt').read_text())
        drive = day / 'V1_01_easy_head_sync'
        self.assertEqual(len(list((drive / 'image_01/data').iterdir())), 60)
        image = cv2.imread(str(drive / 'image_01/data/0000000059.png'), -1)
        self.assertEqual((image.shape, image.min(), image.max()), ((480, 752), 100, 100))
        stamps = (drive / 'image_00/timestamps.txt').read_text()
        self.assertTrue(stamps.startswith('2014-06-25 16:54:33.262142976\n'))


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
