#!/usr/bin/python3
"""Plays a synthetic street with rviz:=true and looks at rviz: no panel may be empty.

Arguments: the repository, a folder with the tools. Exit status 77: rviz cannot be run here.
"""

import os
import shutil
import subprocess
import sys
import tempfile

import cv2
import numpy as np

REPOSITORY, TOOLS = sys.argv[1:3]

# Places in the window of config/predictive_stereo.rviz: left, top, right, bottom.
IMAGES = {'left image': (940, 90, 1560, 270), 'disparity': (940, 320, 1560, 500),
          'standard deviation': (940, 550, 1560, 730), 'residual': (940, 780, 1560, 960)}
SCENE = (20, 70, 870, 960)
BACKGROUND = 48


def main():
    for program in ('rviz', 'Xvfb', 'import'):
        if not shutil.which(program):
            print('skipped: %s is not installed' % program)
            return 77
    with tempfile.TemporaryDirectory(prefix='rviz_test_') as work:
        bag, shot = os.path.join(work, 'street.bag'), os.path.join(work, 'rviz.png')
        subprocess.check_call([os.path.join(TOOLS, 'street_to_bag'), bag, '--frames', '30'],
                              stdout=subprocess.DEVNULL)
        take = [os.path.join(REPOSITORY, 'scripts', 'rviz_screenshot'), shot, 'demo_street.launch',
                'bag:=' + bag, 'rate:=0.15', '--after', '20']
        # On a busy computer, Mesa's software renderer sometimes takes rviz down at its start.
        if subprocess.call(take) != 0:
            subprocess.check_call(take)
        picture = cv2.imread(shot)

    wrong = []
    if picture is None or picture.shape != (1000, 1600, 3):
        wrong.append('the picture is %s' % (None if picture is None else picture.shape,))
        picture = np.zeros((1000, 1600, 3), np.uint8)

    def cut(place):
        left, top, right, bottom = place
        return picture[top:bottom, left:right].astype(float)

    for name, place in IMAGES.items():
        spread = cut(place).std()
        print('%s: standard deviation %.1f' % (name, spread))
        if spread < 8:
            wrong.append('%s is empty' % name)
    colour = np.ptp(cut(IMAGES['disparity']), axis=2).mean()
    if colour < 50:
        wrong.append('disparity has no colours: %.1f' % colour)
    filled = (np.abs(cut(SCENE) - BACKGROUND).max(axis=2) > 8).mean()
    print('3-D view: %.0f %% filled' % (100 * filled))
    if filled < 0.15:
        wrong.append('the 3-D view has no points: %.1f %% are filled' % (100 * filled))
    scene = cut(SCENE)
    red = ((scene[:, :, 2] > 150) & (scene[:, :, 1] < 120) & (scene[:, :, 0] < 120)).sum()
    print('3-D view: %d red pixels' % red)
    if red < 20:
        wrong.append('the 3-D view has no path: %d red pixels' % red)
    for text in wrong:
        print(text, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
