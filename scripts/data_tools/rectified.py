"""Calibration of images that are rectified already, and rectification of EuRoC's."""

import datetime
import re

import cv2
import numpy

from plan import BadInput, read_lines, write

EUROC_SIZE = (752, 480)


def numbers(values):
    return ' '.join('%.12e' % value for value in values)


def calibration_text(time, size, left, right):
    """calib_cam_to_cam.txt of KITTI's raw recordings.

    left, right: the 3x4 projections of two cameras without distortion and rotation.
    """
    lines = ['calib_time: ' + time, 'corner_dist: 0.000000e+00']
    for number, projection in enumerate((left, right)):
        values = [('S', '%.6e %.6e' % size), ('K', numbers(projection[:, :3].flat)), ('D', numbers([0] * 5)),
                  ('R', numbers(numpy.eye(3).flat)),
                  ('T', numbers([projection[0, 3] / projection[0, 0], 0, 0])),
                  ('S_rect', '%.6e %.6e' % size), ('R_rect', numbers(numpy.eye(3).flat)),
                  ('P_rect', numbers(projection.flat))]
        lines += ['%s_%02d: %s' % (name, number, value) for name, value in values]
    return '\n'.join(lines) + '\n'


def odometry_projection(path, name):
    """P0 or P1 of calib.txt of the odometry benchmark."""
    for line in read_lines(path):
        key, _, values = line.partition(':')
        if key == name and len(values.split()) == 12:
            return floats(path, values.split()).reshape(3, 4)
    raise BadInput('%s: has no line "%s:" with 12 numbers; unpack it again' % (path, name))


def floats(path, words):
    try:
        return numpy.array([float(word) for word in words])
    except ValueError as error:
        raise BadInput('%s: %s; unpack it again' % (path, error)) from error


def odometry_calibration(target, calibration, image):
    height, width = read_image(image).shape
    write(target, calibration_text('01-Jan-1970 00:00:00', (width, height),
                                   odometry_projection(calibration, 'P0'),
                                   odometry_projection(calibration, 'P1')))


def odometry_stamps(day, count):
    """Seconds of times.txt as time stamps of a day."""
    def make(target, source):
        seconds = floats(source, read_lines(source)[:count])
        if len(seconds) < count:
            raise BadInput('%s: has %d lines, %d are needed; unpack it again' % (source, len(seconds), count))
        write(target, ''.join('%s 00:00:%012.9f\n' % (day, second) for second in seconds))
    return make


def odometry_poses(count):
    def make(target, source):
        lines = [floats(source, line.split()) for line in read_lines(source)[:count]]
        if len(lines) < count or any(len(line) != 12 for line in lines):
            raise BadInput('%s: %d lines of 12 numbers are needed; unpack it again' % (source, count))
        write(target, ''.join(numbers(line) + '\n' for line in lines))
    return make


def read_image(path, flag=cv2.IMREAD_GRAYSCALE):
    image = cv2.imread(path, flag)
    if image is None:
        raise BadInput('%s: cannot be read as an image; unpack it again' % path)
    return image


def write_image(target, image):
    if not cv2.imwrite(target, image):
        raise OSError('%s: cannot be written' % target)


def grey(target, source):
    """Colour to grey."""
    write_image(target, cv2.cvtColor(read_image(source, cv2.IMREAD_COLOR), cv2.COLOR_BGR2GRAY))


class EurocRig:
    """Cameras of EuRoC as their sensor.yaml describe them, and how to rectify their images."""

    def __init__(self, left, right):
        cameras = [self._camera(path) for path in (left, right)]
        left_to_right = numpy.linalg.inv(cameras[1][2]) @ cameras[0][2]
        # alpha 0: no pixel of the result lies outside of the camera's image.
        found = cv2.stereoRectify(cameras[0][0], cameras[0][1], cameras[1][0], cameras[1][1], EUROC_SIZE,
                                  left_to_right[:3, :3], left_to_right[:3, 3],
                                  flags=cv2.CALIB_ZERO_DISPARITY, alpha=0)
        rotations, self.projections = found[:2], found[2:4]
        self._maps = [cv2.initUndistortRectifyMap(camera[0], camera[1], rotation, projection, EUROC_SIZE,
                                                  cv2.CV_32FC1)
                      for camera, rotation, projection in zip(cameras, rotations, self.projections)]

    @staticmethod
    def _camera(path):
        """(3x3 matrix, distortion, pose in the body)."""
        text = '\n'.join(read_lines(path))

        def values(name, count):
            found = re.search(r'\b%s:\s*\[([^]]*)\]' % name, text)
            words = found.group(1).split(',') if found else []
            if len(words) != count:
                raise BadInput("%s: '%s' has %d values instead of %d; unpack it again" %
                               (path, name, len(words), count))
            return floats(path, words)

        fx, fy, cx, cy = values('intrinsics', 4)
        matrix = numpy.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        return matrix, values('distortion_coefficients', 4), values('data', 16).reshape(4, 4)

    def rectify(self, camera):
        """A step for images of camera 0 or 1."""
        def make(target, source):
            image = read_image(source)
            if image.shape[::-1] != EUROC_SIZE:
                raise BadInput('%s: has %dx%d pixels instead of %dx%d; is it of EuRoC?' %
                               ((source,) + image.shape[::-1] + EUROC_SIZE))
            write_image(target, cv2.remap(image, *self._maps[camera], cv2.INTER_LINEAR))
        return make

    def calibration(self, target):
        write(target, calibration_text('25-Jun-2014 00:00:00', EUROC_SIZE, *self.projections))


def stamp_text(stamp_ns):
    second = datetime.datetime.fromtimestamp(stamp_ns // 10**9, datetime.timezone.utc)
    return '%s.%09d\n' % (second.strftime('%Y-%m-%d %H:%M:%S'), stamp_ns % 10**9)
