"""roslaunch with a master of its own, so that nothing that runs already is disturbed."""

import os
import signal
import socket
import subprocess


class LaunchError(Exception):
    """roslaunch ended, or did not do what was asked for."""


def named(arguments):
    """name:=value arguments as a dictionary; the later of two values of a name holds."""
    for argument in arguments:
        if ':=' not in argument:
            raise LaunchError("'%s' is no launch argument: write name:=value" % argument)
    return dict(argument.split(':=', 1) for argument in arguments)


def topics(launch_file, arguments):
    """(namespace of the outputs, topics of the images) of a launch file of this package."""
    given = named(arguments)
    if launch_file == 'kitti.launch':
        color = given.get('cameras', 'gray') == 'color'
        profile = given.get('profile', 'raw')
        if profile == 'eth':
            images = ['/cam02/image_raw', '/cam03/image_raw'] if color else \
                ['/cam00/image_raw', '/cam01/image_raw']
        else:
            images = ['/kitti/camera_%s_%s/image_%s' %
                      ('color' if color else 'gray', side, 'rect' if profile == 'odom' else 'raw')
                      for side in ('left', 'right')]
        return '/kitti', images
    if launch_file == 'demo_street.launch':
        camera = '/street'
    elif given.get('camera', '').strip('/'):
        camera = '/' + given['camera'].strip('/')
    else:
        raise LaunchError('which camera? Add camera:=<its namespace>')
    image = 'image_raw' if given.get('rectify', '') in ('true', 'True', '1') else 'image_rect'
    names = [given.get(side + '_image', '%s/%s' % (side, image)) for side in ('left', 'right')]
    return camera, [name if name.startswith('/') else camera + '/' + name for name in names]


def free_port():
    with socket.socket() as probe:
        try:
            probe.bind(('localhost', 0))
        except socket.gaierror as error:
            raise LaunchError('the name localhost has no address (%s), and ROS needs it: add the line '
                              '"127.0.0.1 localhost" to /etc/hosts' % error.strerror) from error
        return probe.getsockname()[1]


class Launch:
    """A running launch file; use it as a context."""

    def __init__(self, launch_file, arguments, log_folder):
        port = free_port()
        os.makedirs(log_folder, exist_ok=True)
        self.environment = dict(os.environ, ROS_MASTER_URI='http://localhost:%d' % port,
                                ROS_HOSTNAME='localhost', ROS_LOG_DIR=log_folder)
        self.environment.pop('ROS_IP', None)
        self.log = os.path.join(log_folder, 'roslaunch.log')
        self._output = open(self.log, 'w')
        self._process = subprocess.Popen(
            ['roslaunch', '-p', str(port), 'predictive_stereo', launch_file] +
            ['%s:=%s' % item for item in named(arguments).items()],
            env=self.environment, stdout=self._output, stderr=subprocess.STDOUT, start_new_session=True)

    def check(self):
        """Raises LaunchError where roslaunch has ended."""
        if self._process.poll() is not None:
            raise LaunchError('roslaunch ended (exit status %d):\n%s' %
                              (self._process.returncode, self.tail()))

    def tail(self, lines=25):
        with open(self.log, errors='replace') as log:
            return ''.join(log.readlines()[-lines:])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for number, patience_s in ((signal.SIGINT, 20), (signal.SIGTERM, 5), (signal.SIGKILL, 5)):
            if self._process.poll() is not None:
                break
            os.killpg(self._process.pid, number)
            try:
                self._process.wait(patience_s)
            except subprocess.TimeoutExpired:
                pass
        self._output.close()
