#!/usr/bin/python3
"""scripts/report on a folder as the tools write it. Argument: the repository."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import cv2
import numpy as np
import yaml

SCRIPT = pathlib.Path(sys.argv[1]) / 'scripts/report'
SIZE = (64, 160)
BOXES = 'sequence,frame,what,id,class,x1,y1,x2,y2,distance_m,speed_mps,motion,score,age,verdict,found_by\n'


class Report(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.dir = pathlib.Path(folder.name)

    def map(self, values):
        """A map, unknown in the top quarter; values: of the left and the right half."""
        coded = np.zeros(SIZE, np.uint16)
        coded[16:, :80], coded[16:, 80:] = (256 * value for value in values)
        name = 'map%d.png' % len(os.listdir(self.dir))
        cv2.imwrite(str(self.dir / name), coded)
        return name

    def page(self, *items, title='a <b>'):
        (self.dir / 'report.yaml').write_text(
            yaml.dump({'title': title, 'provenance': 'by <me>', 'items': list(items)}, sort_keys=False))
        result = subprocess.run([SCRIPT, self.dir], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                check=False)
        self.assertEqual(result.returncode, 0, result.stdout)
        return (self.dir / 'index.html').read_text()

    def picture(self, name):
        return cv2.imread(str(self.dir / 'pictures' / name))

    def test_maps_become_colours(self):
        cv2.imwrite(str(self.dir / 'left.png'), np.full(SIZE, 100, np.uint8))
        truth = np.zeros(SIZE, np.uint16)
        truth[:, :80], truth[:, 80:] = 8 * 256, 20 * 256
        cv2.imwrite(str(self.dir / 'truth.png'), truth)
        page = self.page({'frame': '<wall>', 'left': 'left.png', 'truth': 'truth.png', 'methods': [{
            'name': 'ours', 'disparity': self.map((8.5, 8.5)), 'sigma': self.map((1, 1)), 'width': self.map((16, 128)),
            'range': '128', 'measured': self.map((9, 9)), 'predicted': self.map((9, 11.5)),
            'boxes': [['100', '30', '20', '20']]}]})
        self.assertEqual(page.count('<figure>'), 6)
        self.assertIn('&lt;wall&gt;, left image', page)
        self.assertIn('0 (blue) to 128 (red)', page)
        errors = self.picture('0003.png')
        self.assertEqual(errors[40, 10].tolist(), [0, 200, 42])  # 0.5 px off
        self.assertEqual(errors[40, 100].tolist(), [0, 0, 255])  # an outlier
        self.assertEqual(errors[10, 100].tolist(), [255, 0, 255])  # invalid
        difference = self.picture('0006.png')
        self.assertEqual(difference[10, 100].tolist(), [0, 0, 0])  # not measured
        self.assertEqual(difference[40, 40].tolist(), [128, 0, 0])  # as predicted
        self.assertNotEqual(difference[60, 140].tolist(), [128, 0, 0])  # 2.5 px apart
        self.assertEqual(difference[30, 110].tolist(), [255, 255, 255])  # an object's box

    def test_error_image_is_bluest_where_errors_add_up(self):
        cv2.imwrite(str(self.dir / 'sums.png'), np.array([[0, 32768, 65535]], np.uint16))
        self.page({'error_image': 'sums.png', 'title': 'errors'})
        self.assertEqual(self.picture('sums.png').tolist(), [[[255, 255, 255], [255, 127, 127], [255, 0, 0]]])

    def test_boxes_have_the_colours_of_their_outcomes(self):
        (self.dir / 'frames').mkdir()
        for number in 1, 2:
            cv2.imwrite(str(self.dir / ('frames/a_b_00000%d.png' % number)), np.zeros((100, 200), np.uint8))
        (self.dir / 'frames.csv').write_text(BOXES + '"a, b",1,label,3,car,10,20,60,70,9.00,-,away,,,missed,\n'
                                                     '"a, b",1,object,4,,100,20,150,70,-,1.26,,0.9,7,false,\n'
                                                     '"a, b",2,object,4,,100,20,150,70,8.00,1.00,,0.9,8,right,\n')
        page = self.page({'detections': 'frames.csv', 'left': {'a, b': 'frames/a_b_'}})
        first, second = self.picture('a_b_000001.png'), self.picture('a_b_000002.png')
        self.assertEqual(first[40, 10].tolist(), [255, 0, 255])
        self.assertEqual(first[40, 100].tolist(), [0, 0, 255])
        self.assertEqual(second[40, 100].tolist(), [0, 200, 0])
        self.assertIn('a, b, frame 1', page)
        self.assertNotIn('a, b, frame 2', page, 'it has no error')

    def test_plots_show_figures(self):
        (self.dir / 'errors.csv').write_text('error_px,count,share\n-0.01,30,0.3\n0.01,70,0.7\n')
        (self.dir / 'frames.csv').write_text('sequence,method,frame,d1_percent,d1f_percent,mean_width_px\n'
                                             'a,ours,1,2,3,4\nb,hh,1,2,3,4\n')
        (self.dir / 'variance.csv').write_text('sequence,sigmas,share\na,0,0\na,1,0.7\n')
        (self.dir / 'paths.csv').write_text('sequence,frame,true_right_m,true_ahead_m,estimated_right_m,'
                                            'estimated_ahead_m\na,0,0,0,0,0\nb,0,0,0,0,0\n')
        page = self.page({'errors': 'errors.csv', 'title': 'Noise'}, {'outliers': 'frames.csv', 'sequence': 'a'},
                         {'variance': 'variance.csv', 'sequence': 'a'}, {'paths': 'paths.csv'})
        self.assertEqual(page.count('<svg'), 5)
        self.assertIn('Noise: mean +0.004, sigma 0.009', page)
        self.assertNotIn('>hh<', page)

    def test_figures_are_explained(self):
        """By the titles that the programs give their pages."""
        script = SCRIPT.read_text()
        titles = re.findall(r"^    '([^']+)':$", script[script.index('LEGENDS = {'):script.index('class Page')], re.MULTILINE)
        self.assertEqual(len(titles), 3)
        programs = ''.join(path.read_text() for path in (SCRIPT.parent.parent / 'src/evaluation/tools').glob('*.cpp'))
        for title in titles:
            self.assertIn('"%s"' % title, programs)
        self.assertIn('filled as the devkit', self.page({'heading': 'all'}, title='KITTI 2015, single pairs'))

    def test_names_what_is_wrong(self):
        def refused():
            result = subprocess.run([SCRIPT, self.dir], stderr=subprocess.PIPE, text=True, check=False)
            self.assertEqual(result.returncode, 2)
            return result.stderr
        self.assertIn('report.yaml: No such file', refused())
        for text in ('items: [', 'items: [{unknown: 1}]', 'title: a', '[]'):
            (self.dir / 'report.yaml').write_text(text)
            self.assertIn('is not a report of this package', refused())


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1], verbosity=2)
