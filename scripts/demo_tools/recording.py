#!/usr/bin/python3
"""Records what the nodelets publish for the frames that are to be drawn.

As a program it is a node, started by record() below; messages are kept as they come, because
unpacking them would take the nodelets' processor time.
"""

import math
import os
import pickle
import struct
import subprocess
import sys
import threading
import time
from collections import namedtuple

from progress import Progress

# Topics in the camera's namespace; a frame with one message of each is complete.
IMAGES = ('moving_objects/image', 'disparity', 'disparity_variance', 'moving_objects/residual')
SMALL = ('odometry', 'moving_objects', 'row_alignment')

# complete: number of complete frames. frames: paths of pickled {topic: bytes} of some of them, by
# stamp. small: {topic: [bytes]}. diagnostics: [bytes]. camera: the namespace.
Recording = namedtuple('Recording', 'camera complete frames small diagnostics')

START_S = 60  # patience until the nodelets are up
SILENCE_S = 10  # patience without a clock, while playing
DRAIN_S = 3  # silence of the outputs after the bag has ended


def count_pairs(bag, images):
    """Stereo pairs in a bag."""
    import rosbag
    try:
        with rosbag.Bag(bag) as opened:
            return min(opened.get_message_count(topic) for topic in images)
    except rosbag.ROSBagException as error:
        raise OSError('%s: cannot be read as a bag (%s)' % (bag, error)) from error


def record(launch, camera, folder, pairs, wanted):
    """Plays the paused bag of a launch file, and records."""
    process = subprocess.Popen([sys.executable, os.path.abspath(__file__), camera, folder,
                                str(pairs), str(wanted)], env=launch.environment)
    try:
        while process.poll() is None:
            launch.check()
            time.sleep(0.2)
    finally:
        if process.poll() is None:
            process.terminate()
            process.wait()
    summary = os.path.join(folder, 'summary')
    if not os.path.exists(summary):
        return Recording(camera, 0, [], {}, [])
    with open(summary, 'rb') as file:
        return Recording(*pickle.load(file))


def stamp_of(data):
    """Stamp [ns] of a serialised message that begins with a header."""
    seconds, nanoseconds = struct.unpack_from('<II', data, 4)
    return seconds * 1000000000 + nanoseconds


class Recorder:
    """Gathers messages by stamp, and keeps every so-many-th complete frame on disk."""

    def __init__(self, camera, folder, pairs, wanted):
        self.camera, self.folder, self.pairs = camera, folder, pairs
        self.every = max(1, math.ceil(pairs / wanted))
        self.lock = threading.Lock()
        self.waiting = {}
        self.complete = 0
        self.frames = []
        self.small = {topic: [] for topic in SMALL}
        self.diagnostics = []
        self.last_output = time.monotonic()
        self.last_clock = time.monotonic()

    def add(self, topic, data):
        with self.lock:
            self.last_output = time.monotonic()
            if topic in self.small:
                self.small[topic].append(data)
                return
            stamp = stamp_of(data)
            frame = self.waiting.setdefault(stamp, {})
            frame[topic] = data
            if len(frame) == len(IMAGES):
                del self.waiting[stamp]
                self.keep(frame)
            elif len(self.waiting) > 30:
                del self.waiting[min(self.waiting)]

    def keep(self, frame):
        if self.complete % self.every == 0:
            path = os.path.join(self.folder, '%06d' % self.complete)
            with open(path, 'wb') as file:
                pickle.dump(frame, file, protocol=4)
            self.frames.append(path)
        self.complete += 1

    def save(self):
        with self.lock:
            summary = (self.camera, self.complete, self.frames, self.small, self.diagnostics)
        with open(os.path.join(self.folder, 'summary'), 'wb') as file:
            pickle.dump(summary, file)


def until(condition, patience_s):
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.1)
    return False


def main(camera, folder, pairs, wanted):
    import rosgraph
    import rospy
    from rospy.msg import AnyMsg
    from rosgraph_msgs.msg import Clock
    from std_srvs.srv import SetBool

    recorder = Recorder(camera, folder, int(pairs), int(wanted))
    master = rosgraph.Master('recorder')
    # Not before the launch file has set use_sim_time: rospy asks only once.
    if not until(master.is_online, START_S):
        return 'no ROS master'
    if not until(lambda: any(node == '/player' for _, nodes in master.getSystemState()[2]
                             for node in nodes), START_S):
        return 'rosbag play did not start'
    rospy.init_node('recorder', anonymous=True, disable_signals=True)

    subscribers = [
        rospy.Subscriber('%s/%s' % (camera, topic), AnyMsg,
                         lambda message, topic=topic: recorder.add(topic, message._buff),
                         queue_size=None, tcp_nodelay=True) for topic in IMAGES + SMALL]
    subscribers.append(rospy.Subscriber(
        '/diagnostics', AnyMsg, lambda message: recorder.diagnostics.append(message._buff)))

    def clock(_):
        recorder.last_clock = time.monotonic()

    rospy.Subscriber('/clock', Clock, clock)

    def ready():
        # Every topic has its publisher, and that its listener.
        return all(subscriber.get_num_connections() > 0 for subscriber in subscribers)

    if not until(ready, START_S):
        silent = [s.name for s in subscribers if s.get_num_connections() == 0]
        return 'nobody publishes ' + ', '.join(silent)
    time.sleep(1)  # the nodelets' own subscriptions to each other and to the player
    rospy.wait_for_service('/player/pause_playback', START_S)
    rospy.ServiceProxy('/player/pause_playback', SetBool)(False)

    def played():
        over = time.monotonic() - recorder.last_clock
        quiet = time.monotonic() - recorder.last_output
        if over < DRAIN_S:
            return False
        gone = all('/player' not in nodes for _, nodes in master.getSystemState()[0])
        return (gone and quiet > DRAIN_S) or over > SILENCE_S

    recorder.last_output = recorder.last_clock = time.monotonic()
    with Progress('playing', recorder.pairs) as bar:
        while not played():
            bar.update(recorder.complete)
            time.sleep(0.2)
        bar.update(recorder.complete)
    recorder.save()
    return 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
