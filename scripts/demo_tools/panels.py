"""Draws what the nodelets published for a frame, and compares it with the truth where it is known."""

import os
import pickle
import struct
import sys
from collections import namedtuple

import cv2
import numpy as np
import rosbag
from sensor_msgs.msg import Image
from stereo_msgs.msg import DisparityImage

from progress import Progress

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), '../page_tools'))
from drawing import coloured  # noqa: E402

CAPTION_PX = 34
GAP_PX = 6
LARGEST_SIGMA_PX = 3.0
LARGEST_RESIDUAL = 6.0
THUMBNAIL_WIDTH_PX = 1200

# stamp_ns: of the left image. path: of the PNG. jpeg: a smaller version. figures: {name: value}.
Drawn = namedtuple('Drawn', 'stamp_ns path jpeg figures')


def unpack(kind, data):
    message = kind()
    message.deserialize(data)
    return message


def array(image):
    """The pixels of a sensor_msgs/Image: float32 or uint8, one or three channels."""
    depth, channels = {'32FC1': (np.float32, 1), 'bgr8': (np.uint8, 3),
                       'mono8': (np.uint8, 1)}[image.encoding]
    kind = np.dtype(depth).newbyteorder('>' if image.is_bigendian else '<')
    rows = np.frombuffer(image.data, np.uint8).reshape(image.height, image.step)
    pixels = np.ascontiguousarray(rows[:, :image.width * channels * kind.itemsize]).view(kind)
    return pixels.reshape((image.height, image.width, channels) if channels > 1 else
                          (image.height, image.width))


def diverging_map():
    """256 colours from blue over light grey to red, as bgr."""
    stops = np.array([[130, 30, 20], [235, 160, 90], [235, 235, 235], [90, 140, 245], [20, 10, 150]],
                     np.float64)
    place = np.linspace(0, len(stops) - 1, 256)
    return np.stack([np.interp(place, np.arange(len(stops)), stops[:, c]) for c in range(3)],
                    axis=-1).astype(np.uint8)


DIVERGING = diverging_map()


def panel(picture, caption, scale=None):
    """A picture under its caption; scale: (smallest, largest, colours, unit)."""
    height, width = picture.shape[:2]
    result = np.full((height + CAPTION_PX, width, 3), 32, np.uint8)
    result[CAPTION_PX:] = picture
    size = 0.65 if width >= 600 else 0.45
    cv2.putText(result, caption, (8, 24), cv2.FONT_HERSHEY_SIMPLEX, size, (235, 235, 235), 1,
                cv2.LINE_AA)
    if scale and width >= 600:
        smallest, largest, colours, unit = scale
        bar = np.tile(np.linspace(smallest, largest, 160)[None], (14, 1))
        left = width - 160 - 90
        result[10:24, left:left + 160] = coloured(bar, smallest, largest, colours, bar == bar)
        for text, x in (('%g' % smallest, left - 34), ('%g %s' % (largest, unit), left + 166)):
            cv2.putText(result, text, (x, 23), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (235, 235, 235), 1,
                        cv2.LINE_AA)
    return result


def beside(left, right):
    return np.hstack([left, np.full((left.shape[0], GAP_PX, 3), 32, np.uint8), right])


def stack(rows):
    gap = np.full((GAP_PX, rows[0].shape[1], 3), 32, np.uint8)
    return np.vstack([rows[0], gap, rows[1]])


class Truth:
    """truth/disparity of a synthetic bag, by stamp."""

    def __init__(self, bag, camera):
        self.bag = bag
        self.topic = camera + '/truth/disparity'
        # The times of a synthetic bag are the stamps.
        self.known = bag.get_message_count(self.topic) > 0

    def at(self, stamp):
        if not self.known:
            return None
        for _, message, _ in self.bag.read_messages(self.topic, start_time=stamp, end_time=stamp):
            return array(message.image)
        return None


def figures(disparity, known, sigma, truth):
    """What can be told of a frame in numbers."""
    result = {'density [%]': 100 * known.mean(),
              'median standard deviation [px]': float(np.median(sigma[known])) if known.any() else
                                                float('nan')}
    if truth is not None and known.any():
        error = np.abs(disparity - truth)
        wrong = (error > 3) & (error > 0.05 * truth)
        result['outliers [%]'] = 100 * wrong[known].mean()
        result['outliers, unknown counted as wrong [%]'] = 100 * (wrong | ~known).mean()
        result['within 1 sigma [%]'] = 100 * (error <= sigma)[known].mean()
        result['within 2 sigma [%]'] = 100 * (error <= 2 * sigma)[known].mean()
    return result


def load(path):
    with open(path, 'rb') as file:
        return pickle.load(file)


def disparity_scale(paths):
    """Largest disparity of the colours: what nearly all pixels stay below."""
    largest = 16
    for path in paths[::max(1, len(paths) // 8)]:
        message = unpack(DisparityImage, load(path)['disparity'])
        values = array(message.image)
        known = values >= message.min_disparity
        if known.any():
            largest = max(largest, np.percentile(values[known], 99.5))
    return float(np.ceil(largest / 10) * 10)


def draw(frame, largest_px, truth):
    """The picture of a frame and its figures."""
    disparity_message = unpack(DisparityImage, frame['disparity'])
    left = array(unpack(Image, frame['moving_objects/image']))
    disparity = array(disparity_message.image)
    known = disparity >= disparity_message.min_disparity
    sigma = np.sqrt(array(unpack(Image, frame['disparity_variance'])))
    residual = array(unpack(Image, frame['moving_objects/residual']))

    picture = stack([
        beside(panel(left, 'Left image with moving objects'),
               panel(coloured(disparity, 0, largest_px, cv2.COLORMAP_TURBO, known), 'Disparity',
                     (0, largest_px, cv2.COLORMAP_TURBO, 'px'))),
        beside(panel(coloured(sigma, 0, LARGEST_SIGMA_PX, cv2.COLORMAP_VIRIDIS, known),
                     'Standard deviation of disparity',
                     (0, LARGEST_SIGMA_PX, cv2.COLORMAP_VIRIDIS, 'px')),
               panel(coloured(residual, -LARGEST_RESIDUAL, LARGEST_RESIDUAL, DIVERGING,
                              residual != 0),
                     'Residual to the prediction',
                     (-LARGEST_RESIDUAL, LARGEST_RESIDUAL, DIVERGING, 'sigma')))])
    return picture, figures(disparity, known, sigma, truth)


def draw_all(recording, bag_path, folder):
    """Draws the recorded frames into a folder; returns a list of Drawn."""
    import rospy
    largest_px = disparity_scale(recording.frames)
    drawn = []
    with rosbag.Bag(bag_path) as bag, Progress('drawing', len(recording.frames)) as bar:
        truths = Truth(bag, recording.camera)
        for number, path in enumerate(recording.frames):
            frame = load(path)
            seconds, nanoseconds = struct.unpack_from('<II', frame['disparity'], 4)
            picture, values = draw(frame, largest_px,
                                   truths.at(rospy.Time(seconds, nanoseconds)))
            name = os.path.join(folder, 'frame_%s.png' % os.path.basename(path))
            if not cv2.imwrite(name, picture, [cv2.IMWRITE_PNG_COMPRESSION, 3]):
                raise OSError('cannot write ' + name)
            scale = min(1.0, THUMBNAIL_WIDTH_PX / picture.shape[1])
            small = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
            jpeg = cv2.imencode('.jpg', small, [cv2.IMWRITE_JPEG_QUALITY, 80])[1].tobytes()
            drawn.append(Drawn(seconds * 1000000000 + nanoseconds, name, jpeg, values))
            bar.update(number + 1)
    return drawn
