"""The data sets: which files of the public downloads they have, and under which names."""

import collections
import os

import rectified
from plan import BadInput, cut_lines, read_lines, write

REPOSITORY = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
LABELS = os.path.join(REPOSITORY, 'test/data/labels')
KITTI = 'https://www.cvlibs.net/datasets/kitti/'
DAY = '2011_09_26'

# folders: where people unpack it, relative to KITTI_ROOT.
Download = collections.namedtuple('Download', 'name page folders')


def raw(name):
    return Download(name, KITTI + 'raw_data.php', ('', 'raw', 'raw_data'))


RAW_CALIBRATION = raw('"calibration" of ' + DAY)
ODOMETRY = Download('the odometry data set (grayscale images, calibration files, ground truth poses)',
                    KITTI + 'eval_odometry.php', ('', 'dataset', 'odometry', 'odometry/dataset'))
STEREO_2012 = Download('the stereo 2012 data set, its calibration files and its multi-view extension',
                       KITTI + 'eval_stereo_flow.php?benchmark=stereo',
                       ('', 'stereo_flow_2012', 'data_stereo_flow', 'data_stereo_flow_calib',
                        'data_stereo_flow_multiview'))
STEREO_2015 = Download('the stereo 2015 data set and its calibration files',
                       KITTI + 'eval_scene_flow.php?benchmark=stereo',
                       ('', 'scene_flow_2015', 'data_scene_flow', 'data_scene_flow_calib'))
EUROC = Download('V1_01_easy of the EuRoC MAV data set (ASL format)',
                 'https://projects.asl.ethz.ch/datasets/doku.php?id=kmavvisualinertialdatasets',
                 ('V1_01_easy', '', 'euroc/V1_01_easy'))

SCENES_2012 = (27, 151)
SCENES_2015 = (2, 3, *range(7, 18), *range(22, 34), *range(43, 72))


def raw_drive(plan, drive, first, count, scans):
    """Frames of a drive of the raw recordings, numbered from 0; scans: laser, GPS and IMU, too."""
    name = '%s_drive_%04d_sync' % (DAY, drive)
    download = raw('"synced+rectified data" of %s_drive_%04d' % (DAY, drive))
    for file in ('calib_cam_to_cam.txt', 'calib_velo_to_cam.txt', 'calib_imu_to_velo.txt'):
        plan.copy('%s/%s' % (DAY, file), plan.source(RAW_CALIBRATION, '%s/%s' % (DAY, file)))
    folders = [('image_00', 'png', ['timestamps']), ('image_01', 'png', ['timestamps'])]
    if scans:
        stamps = ['timestamps', 'timestamps_start', 'timestamps_end']
        folders += [('velodyne_points', 'bin', stamps), ('oxts', 'txt', ['timestamps'])]
        plan.copy('%s/%s/oxts/dataformat.txt' % (DAY, name),
                  plan.source(download, '%s/%s/oxts/dataformat.txt' % (DAY, name)))
    for folder, suffix, lists in folders:
        path = '%s/%s/%s' % (DAY, name, folder)
        for frame in range(count):
            plan.copy('%s/data/%010d.%s' % (path, frame, suffix),
                      plan.source(download, '%s/data/%010d.%s' % (path, first + frame, suffix)))
        for stamps in lists:
            plan.add('%s/%s.txt' % (path, stamps), cut_lines(first, count),
                     plan.source(download, '%s/%s.txt' % (path, stamps)))


def odometry_06(plan):
    """Raw drive 0020 of 2011_09_30 in the layout of the raw recordings, with poses of cam0."""
    day, count = '2011_09_30', 51
    drive = '%s/%s_drive_0020_sync' % (day, day)
    calibration = plan.source(ODOMETRY, 'sequences/06/calib.txt')
    stamps = plan.source(ODOMETRY, 'sequences/06/times.txt')
    for camera in range(2):
        folder = '%s/image_%02d' % (drive, camera)
        images = [plan.source(ODOMETRY, 'sequences/06/image_%d/%06d.png' % (camera, frame))
                  for frame in range(count)]
        for frame, image in enumerate(images):
            plan.copy('%s/data/%010d.png' % (folder, frame), image)
        plan.add(folder + '/timestamps.txt', rectified.odometry_stamps(day.replace('_', '-'), count), stamps)
    plan.add(drive + '/poses_gt_cam0.txt', rectified.odometry_poses(count),
             plan.source(ODOMETRY, 'poses/06.txt'))
    plan.add(day + '/calib_cam_to_cam.txt', rectified.odometry_calibration, calibration, images[0])


def kitti_2012(plan):
    """Grey images of frames 7 to 11; the truth belongs to frame 10."""
    for scene in SCENES_2012:
        names = ['image_%d/%06d_%02d.png' % (camera, scene, frame)
                 for camera in range(2) for frame in range(7, 12)]
        names += ['%s/%06d_10.png' % (truth, scene)
                  for truth in ('disp_noc', 'disp_occ', 'flow_noc', 'flow_occ')]
        for name in names:
            plan.copy('stereo_flow_2012/training/' + name, plan.source(STEREO_2012, 'training/' + name))
        plan.add('stereo_flow_2012/training/calib/%06d.txt' % scene, _grey_cameras,
                 plan.source(STEREO_2012, 'training/calib/%06d.txt' % scene))


def _grey_cameras(target, source):
    lines = [line for line in read_lines(source) if line.startswith(('P0:', 'P1:'))]
    if len(lines) != 2:
        raise BadInput('%s: has no lines "P0:" and "P1:"; unpack it again' % source)
    write(target, '\n'.join(lines) + '\n')


def kitti_2015(plan):
    """Single pairs, turned to grey."""
    out = 'scene_flow_2015/training/'
    for scene in SCENES_2015:
        name = '%06d_10.png' % scene
        for folder in ('image_2', 'image_3'):
            plan.add(out + '%s/%s' % (folder, name), rectified.grey,
                     plan.source(STEREO_2015, 'training/%s/%s' % (folder, name)))
        for path in ('disp_occ_0/' + name, 'obj_map/' + name, 'calib_cam_to_cam/%06d.txt' % scene):
            plan.copy(out + path, plan.source(STEREO_2015, 'training/' + path))


def euroc(plan):
    """The first 60 pairs of EuRoC's V1_01_easy, rectified, in the layout of KITTI's raw recordings."""
    day, count = '2014_06_25', 60
    sensors = [plan.source(EUROC, 'mav0/cam%d/sensor.yaml' % camera) for camera in range(2)]
    lists = [plan.source(EUROC, 'mav0/cam%d/data.csv' % camera) for camera in range(2)]
    if not all(sensors + lists):
        return
    stamps = [_euroc_stamps(path, count) for path in lists]
    if stamps[0] != stamps[1]:
        raise BadInput('%s: has other stamps than %s; unpack both again' % (lists[1], lists[0]))
    rig = rectified.EurocRig(*sensors)
    plan.add(day + '/calib_cam_to_cam.txt', rig.calibration)
    text = ''.join(rectified.stamp_text(stamp) for stamp in stamps[0])
    for camera in range(2):
        folder = '%s/V1_01_easy_head_sync/image_%02d' % (day, camera)
        for frame, stamp in enumerate(stamps[camera]):
            plan.add('%s/data/%010d.png' % (folder, frame), rig.rectify(camera),
                     plan.source(EUROC, 'mav0/cam%d/data/%d.png' % (camera, stamp)))
        plan.add(folder + '/timestamps.txt', lambda target: write(target, text))


def _euroc_stamps(path, count):
    words = [line.split(',')[0] for line in read_lines(path) if not line.startswith('#')][:count]
    if len(words) < count or not all(word.isdigit() for word in words):
        raise BadInput('%s: %d lines that begin with a stamp [ns] are needed; unpack it again' %
                       (path, count))
    return [int(word) for word in words]


def labels(plan):
    """The shipped labels, where tests look for them."""
    for name in sorted(os.listdir(LABELS)):
        if name.endswith('.csv'):
            plan.copy('labels/' + name, os.path.join(LABELS, name))


SETS = collections.OrderedDict([
    ('0001', lambda plan: raw_drive(plan, 1, 40, 68, False)),
    ('0002', lambda plan: raw_drive(plan, 2, 0, 10, True)),
    ('0009', lambda plan: raw_drive(plan, 9, 0, 51, True)),
    ('0013', lambda plan: raw_drive(plan, 13, 0, 16, False)),
    ('0020', odometry_06),
    ('kitti2012', kitti_2012),
    ('kitti2015', kitti_2015),
    ('euroc', euroc),
])
USUAL = [name for name in SETS if name != 'euroc']
