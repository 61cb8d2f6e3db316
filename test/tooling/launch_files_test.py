#!/usr/bin/python3
"""Loads every launch file with the arguments it is made for: the nodes, topics and parameters that
come out must be those of the nodelets.

Arguments: the repository, a folder with the tools.
"""

import contextlib
import glob
import io
import os
import subprocess
import sys
import unittest
from unittest import mock

import roslaunch as roslaunch_api
import yaml

REPOSITORY, TOOLS = sys.argv[1:3]
sys.path.insert(0, os.path.join(REPOSITORY, 'scripts', 'demo_tools'))
import launching  # noqa: E402
import options  # noqa: E402
LAUNCH = os.path.join(REPOSITORY, 'launch')
THREE = {'ego_motion', 'disparity', 'moving_objects'}


def roslaunch(option, name, *arguments):
    """What the program prints; it runs in this process, because its start takes a second."""
    path = name if os.path.isabs(name) else os.path.join(LAUNCH, name)
    command = ['roslaunch', option, path] + list(arguments)
    printed, errors = io.StringIO(), io.StringIO()
    with mock.patch('sys.argv', command), contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
        try:
            roslaunch_api.main(command)
        except SystemExit as end:
            if end.code:
                raise AssertionError('%s %s: %s' % (name, ' '.join(arguments), errors.getvalue()))
    return printed.getvalue()


def nodes(name, *arguments):
    return set(roslaunch('--nodes', name, *arguments).split())


def params(name, *arguments):
    return yaml.safe_load(roslaunch('--dump-params', name, *arguments)) or {}


def command(node, name, *arguments):
    """Command line of a node, without its path."""
    return roslaunch('--args=' + node, name, *arguments)


def names(tree, prefix=''):
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from names(value, prefix + key + '/')
        else:
            yield prefix + key


KNOWN = set(names(yaml.safe_load(subprocess.check_output(
    [os.path.join(TOOLS, 'replay'), '--parameters'], universal_newlines=True))))


class LaunchFiles(unittest.TestCase):

    def assert_known(self, given, camera):
        """Every parameter of the three nodelets is one that they have."""
        for name in given:
            section = name[len(camera) + 1:].split('/')[0]
            if name.startswith(camera + '/') and section in THREE:
                self.assertIn(name[len(camera) + 1:], KNOWN)

    def test_every_file_is_tested(self):
        self.assertEqual({os.path.basename(path) for path in glob.glob(LAUNCH + '/*.launch')},
                         {'predictive_stereo.launch', 'kitti.launch', 'demo_street.launch'})

    def test_robot_needs_the_camera_only(self):
        self.assertEqual(nodes('predictive_stereo.launch', 'camera:=/stereo'),
                         {'/stereo/' + n for n in THREE | {'predictive_stereo_manager'}})
        given = params('predictive_stereo.launch', 'camera:=/stereo')
        self.assert_known(given, '/stereo')
        # The whole annotated file is loaded where the nodelets look for it.
        self.assertEqual({n for n in KNOWN if '/stereo/' + n not in given}, set())

    def test_parameters_of_an_earlier_launch_are_forgotten(self):
        """A roscore that runs on keeps them otherwise, and a file config has only what differs."""
        for arguments in ['rectify:=true'], ['standalone:=true']:
            config = roslaunch_api.config.ROSLaunchConfig()
            roslaunch_api.xmlloader.XmlLoader().load(os.path.join(LAUNCH, 'predictive_stereo.launch'), config,
                                                     argv=['camera:=/stereo'] + arguments, verbose=False)
            with_parameters = {node.namespace + node.name + '/' for node in config.nodes if node.name != 'predictive_stereo_manager'}
            self.assertGreaterEqual(len(with_parameters), 3)
            self.assertEqual(set(config.clear_params), with_parameters | {'/stereo/predictive_stereo_config/'})

    def test_robot_without_the_camera_is_refused(self):
        with self.assertRaisesRegex(AssertionError, 'camera'):
            nodes('predictive_stereo.launch')

    def test_robot_in_the_drivers_manager(self):
        arguments = ('camera:=stereo', 'manager:=/camera/manager')
        self.assertEqual(nodes('predictive_stereo.launch', *arguments),
                         {'/stereo/' + n for n in THREE})
        self.assertRegex(command('/stereo/disparity', 'predictive_stereo.launch', *arguments),
                         r'load predictive_stereo/Disparity /camera/manager')

    def test_robot_standalone(self):
        arguments = ('camera:=stereo', 'standalone:=true', 'rectify:=true')
        self.assertEqual(nodes('predictive_stereo.launch', *arguments),
                         {'/stereo/' + n for n in THREE | {'rectify_left', 'rectify_right'}})
        self.assertRegex(command('/stereo/ego_motion', 'predictive_stereo.launch', *arguments),
                         r'standalone predictive_stereo/EgoMotion')
        self.assertRegex(command('/stereo/rectify_left', 'predictive_stereo.launch', *arguments),
                         r'standalone predictive_stereo/Rectify')

    def test_robot_with_parts(self):
        arguments = ('camera:=/stereo', 'ego_motion:=false', 'moving_objects:=false')
        self.assertEqual(nodes('predictive_stereo.launch', *arguments),
                         {'/stereo/disparity', '/stereo/predictive_stereo_manager'})
        self.assertEqual(nodes('predictive_stereo.launch', 'camera:=/stereo',
                               'moving_objects:=false'),
                         {'/stereo/' + n for n in
                          ('ego_motion', 'disparity', 'predictive_stereo_manager')})

    def test_rotation_of_others(self):
        arguments = ('camera:=/stereo', 'imu:=/imu/data')
        given = params('predictive_stereo.launch', *arguments)
        self.assert_known(given, '/stereo')
        self.assertIs(given['/stereo/ego_motion/use_imu'], True)
        self.assertRegex(command('/stereo/ego_motion', 'predictive_stereo.launch', *arguments),
                         r'imu:=/imu/data')
        given = params('predictive_stereo.launch', 'camera:=/stereo', 'guess_frame:=wheels')
        self.assertIs(given['/stereo/ego_motion/use_imu'], False)
        self.assertEqual(given['/stereo/ego_motion/guess_frame'], 'wheels')

    def test_odometry_of_others(self):
        arguments = ('camera:=/stereo', 'odometry:=/wheels/odom')
        for node in 'disparity', 'moving_objects':
            self.assertRegex(command('/stereo/' + node, 'predictive_stereo.launch', *arguments), r'\bodometry:=/wheels/odom')
        self.assertNotIn('/wheels/odom', command('/stereo/ego_motion', 'predictive_stereo.launch', *arguments))

    def test_the_demo_finds_the_images_of_each_camera(self):
        for given, images in (
                ([], ['/stereo/left/image_rect', '/stereo/right/image_rect']),
                (['rectify:=true'], ['/stereo/left/image_raw', '/stereo/right/image_raw']),
                (['left_image:=/head/l/mono', 'right_image:=r/mono'], ['/head/l/mono', '/stereo/r/mono'])):
            self.assertEqual(launching.topics('predictive_stereo.launch', ['camera:=/stereo'] + given),
                             ('/stereo', images))

    def test_the_demo_passes_the_choice_of_topics_on(self):
        bag = ['--bag', os.path.realpath(__file__)]
        choice = ['--left', '/head/l/mono', '--right', '/head/r/mono']
        self.assertEqual(options.parse(bag + choice).choice, choice)
        self.assertEqual(options.parse(bag).choice, [])
        for refused in (choice, bag + choice + ['kitti.launch'], ['--bag', '/none.bag']):
            with self.assertRaises(SystemExit):
                options.parse(refused)

    def test_compressed_images(self):
        for name, arguments, prefix in (
                ('predictive_stereo.launch', ('camera:=/stereo',), '/stereo'),
                ('kitti.launch', ('bag:=/some.bag', 'rviz:=false'), '/kitti'),
                ('demo_street.launch', ('bag:=/some.bag', 'rviz:=false'), '/street')):
            given = params(name, 'image_transport:=compressed', *arguments)
            for node in THREE:
                self.assertEqual(given['%s/%s/image_transport' % (prefix, node)], 'compressed')
        # What was rectified is not compressed any more.
        given = params('predictive_stereo.launch', 'camera:=/stereo', 'rectify:=true',
                       'image_transport:=compressed')
        for node in THREE:
            self.assertEqual(given['/stereo/%s/image_transport' % node], 'raw')
        for side in ('left', 'right'):
            self.assertEqual(given['/stereo/rectify_%s/image_transport' % side], 'compressed')

    def test_images_with_other_names(self):
        names = ('camera:=/stereo', 'left_image:=l/mono', 'right_image:=/r/mono')
        self.assertRegex(command('/stereo/disparity', 'predictive_stereo.launch', *names),
                         r'left/image_rect:=l/mono.*right/image_rect:=/r/mono')
        rectified = names + ('rectify:=true',)
        self.assertRegex(command('/stereo/rectify_left', 'predictive_stereo.launch', *rectified),
                         r'image_raw:=l/mono.*image_rect:=left/image_rect')
        self.assertRegex(command('/stereo/rectify_right', 'predictive_stereo.launch', *rectified), r'image_raw:=/r/mono')
        self.assertRegex(command('/stereo/disparity', 'predictive_stereo.launch', *rectified),
                         r'left/image_rect:=left/image_rect')

    def test_robot_with_everything(self):
        arguments = ('camera:=/stereo', 'rectify:=true', 'rviz:=true', 'bag:=/some.bag', 'rate:=0.5',
                     'approximate_sync:=false', 'sync_tolerance:=0.03', 'publish_tf:=false',
                     'lazy:=true', 'odom_frame:=map', 'base_frame:=base', 'robot_mask:=/mask.png',
                     'left_image:=/l', 'left_info:=/li')
        extra = {'predictive_stereo_manager', 'rectify_left', 'rectify_right', 'rviz'}
        self.assertEqual(nodes('predictive_stereo.launch', *arguments),
                         {'/stereo/' + n for n in THREE | extra} | {'/player'})
        given = params('predictive_stereo.launch', *arguments)
        self.assert_known(given, '/stereo')
        self.assertIs(given['/use_sim_time'], True)
        for node in ('ego_motion', 'disparity'):
            self.assertIs(given['/stereo/%s/approximate_sync' % node], False)
            self.assertEqual(given['/stereo/%s/sync_tolerance' % node], 0.03)
            self.assertEqual(given['/stereo/%s/robot_mask' % node], '/mask.png')
        for node in THREE:
            self.assertEqual(given['/stereo/%s/odom_frame' % node], 'map')
        self.assertIs(given['/stereo/ego_motion/publish_tf'], False)
        self.assertIs(given['/stereo/ego_motion/lazy'], True)
        self.assertEqual(given['/stereo/ego_motion/base_frame'], 'base')
        self.assertRegex(command('/stereo/rectify_left', 'predictive_stereo.launch', *arguments),
                         r'image_raw:=/l\b')
        self.assertRegex(command('/player', 'predictive_stereo.launch', *arguments),
                         r'--delay 2 --rate 0.5')

    def test_robot_whose_camera_is_the_base(self):
        given = params('predictive_stereo.launch', 'camera:=/stereo', 'camera_is_base:=true')
        self.assertEqual(given['/stereo/ego_motion/base_frame'], '')

    def test_kitti(self):
        expected = {
            ('raw', 'gray'): '/kitti/camera_gray_left/image_raw',
            ('raw', 'color'): '/kitti/camera_color_left/image_raw',
            ('odom', 'gray'): '/kitti/camera_gray_left/image_rect',
            ('odom', 'color'): '/kitti/camera_color_left/image_rect',
            ('eth', 'gray'): '/cam00/image_raw',
            ('eth', 'color'): '/cam02/image_raw',
        }
        for (profile, cameras), left in expected.items():
            arguments = ('bag:=/some.bag', 'profile:=' + profile, 'cameras:=' + cameras,
                         'rviz:=false')
            self.assertEqual(nodes('kitti.launch', *arguments),
                             {'/kitti/' + n for n in THREE | {'predictive_stereo_manager'}} |
                             {'/player'})
            right = left.replace('_left', '_right').replace('00', '01').replace('02', '03')
            line = command('/kitti/ego_motion', 'kitti.launch', *arguments)
            for topic, source in (('left/image_rect', left), ('right/image_rect', right),
                                  ('left/camera_info', os.path.dirname(left) + '/camera_info'),
                                  ('right/camera_info', os.path.dirname(right) + '/camera_info')):
                self.assertIn('%s:=%s ' % (topic, source), line + ' ')
            given = params('kitti.launch', *arguments)
            self.assert_known(given, '/kitti')
            # raw bags have base_link; the others have no extrinsics at all.
            self.assertEqual(given.get('/kitti/ego_motion/base_frame'),
                             None if profile == 'raw' else '')
            # The bag's own poses must not get in the way of the odometry's.
            self.assertIn('/tf:=/kitti/tf', command('/player', 'kitti.launch', *arguments))

    def test_kitti_with_the_motion_of_the_bag(self):
        arguments = ('bag:=/some.bag', 'ego_motion:=false', 'rviz:=false')
        self.assertEqual(nodes('kitti.launch', *arguments),
                         {'/kitti/disparity', '/kitti/moving_objects',
                          '/kitti/predictive_stereo_manager', '/player'})
        given = params('kitti.launch', *arguments)
        for node in ('disparity', 'moving_objects'):
            self.assertEqual(given['/kitti/%s/odom_frame' % node], 'world')
        self.assertIn('/tf:=/tf', command('/player', 'kitti.launch', *arguments))

    def test_street(self):
        arguments = ('bag:=/some.bag', 'rviz:=true')
        self.assertEqual(nodes('demo_street.launch', *arguments),
                         {'/street/' + n for n in THREE | {'predictive_stereo_manager', 'rviz'}} |
                         {'/player'})
        self.assert_known(params('demo_street.launch', *arguments), '/street')
        self.assertEqual(nodes('demo_street.launch', *arguments, 'moving_objects:=false',
                               'ego_motion:=false', 'rviz:=false'),
                         {'/street/disparity', '/street/predictive_stereo_manager', '/player'})

    def test_recipes_name_topics_that_there_are(self):
        def recipe(name):
            with open(os.path.join(REPOSITORY, 'config', 'recipes', name + '.yaml')) as file:
                return yaml.safe_load(file)
        ekf = recipe('ekf')
        self.assertEqual(ekf['odom0'], '/stereo/odometry')
        self.assertEqual(ekf['odom0_config'], 6 * [False] + 6 * [True] + 3 * [False])
        self.assertEqual(ekf['base_link_frame'],
                         params('predictive_stereo.launch',
                                'camera:=/stereo')['/stereo/ego_motion/base_frame'])
        costmaps = recipe('costmap')
        for which, topic in (('local_costmap', '/stereo/points2'), ('global_costmap', '/stereo/points2_static')):
            layer = costmaps[which]['obstacle_layer']
            sources = [layer[name] for name in layer['observation_sources'].split()]
            self.assertEqual([source['topic'] for source in sources if source['marking']], [topic])
            floor = [source for source in sources if source['min_obstacle_height'] < 0]
            self.assertEqual([source['clearing'] for source in floor], [True], 'rays to the floor clear')

    def test_every_config_file(self):
        for path in glob.glob(os.path.join(REPOSITORY, 'config', '*.yaml')):
            self.assert_known(params('predictive_stereo.launch', 'camera:=/stereo',
                                     'config:=' + path), '/stereo')


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1], verbosity=2)
