#!/usr/bin/python3
"""Six short bags, one of them broken, through scripts/evaluate_many."""

import csv
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY, TOOLS = map(pathlib.Path, sys.argv[1:3])
SKIPPED = 77
sys.path.insert(0, str(REPOSITORY / 'workflow'))
sys.dont_write_bytecode = True
import figures  # noqa: E402
import recordings  # noqa: E402

# A name that would do something in a shell, in a path, in html and in Snakemake.
HOSTILE = """x'"; $(touch hacked) `touch hacked` <b> {output}"""


def street(path, seed):
    subprocess.run([TOOLS / 'street_to_bag', path, '--scene', 'straight', '--frames', '4', '--size',
                    '248x80', '--seed', str(seed)], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)


class EvaluateMany(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        self.output = self.folder / 'output'

    def evaluate(self, *arguments):
        return subprocess.run(
            [REPOSITORY / 'scripts/evaluate_many', self.folder / 'list', '--cores', '2', '--threads',
             '1', '--tools', TOOLS, '--output', self.output, *arguments],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, cwd=self.folder)

    def jobs(self):
        """When each job ran last."""
        return {str(log.relative_to(self.output / 'logs')): log.stat().st_mtime_ns
                for log in (self.output / 'logs').glob('*/*.log')}

    def results(self):
        with open(self.output / 'results.csv', newline='') as file:
            return {(row['recording'], row['measurement'], row['figure']): float(row['value'])
                    for row in csv.DictReader(file)}

    def test_six_bags_one_of_them_broken(self):
        bags = [self.folder / (name + '.bag') for name in ('a', 'b', 'c', 'd', HOSTILE, 'cut')]
        for seed in range(2):
            street(bags[seed], seed + 1)
        for bag in bags[2:]:
            shutil.copy(bags[0], bag)
        whole = bags[5].read_bytes()
        bags[5].write_bytes(whole[:len(whole) // 2])
        lines = [shlex.quote(bag.name) for bag in bags]
        lines[0] += ' labels=own  # has truth'
        (self.folder / 'list').write_text('# recordings\n\n' + '\n'.join(lines) + '\n')

        first = self.evaluate()
        self.assertEqual(first.returncode, 1, first.stdout)
        self.assertIn('failed: cut, replay: replay: ', first.stdout)
        self.assertIn('6 recordings, 7 measurements, 1 failed', first.stdout)
        found = self.results()
        names = {name for name, _, _ in found}
        self.assertEqual(len(names), 6, names)  # five, and all
        self.assertNotIn('cut', names)
        self.assertEqual(found['all', 'replay', 'pairs'], 20)
        self.assertEqual(found['a', 'replay', 'pairs'], 4)
        self.assertIn(('a', 'detection', 'false_boxes_per_frame'), found)
        page = (self.output / 'index.html').read_text()
        self.assertIn('<h3>cut, replay</h3>', page)
        self.assertIn('cannot be read as a bag', page)
        self.assertEqual(page.count('<rect'), sum(name != 'all' for name, _, _ in found))
        self.assertFalse(list(self.folder.rglob('hacked')), 'a name was taken for a command')
        self.assertFalse(list(self.folder.glob('*/recordings/*/*.part*')))

        # Nothing changed: only what failed is tried again.
        before = self.jobs()
        second = self.evaluate()
        self.assertEqual(second.returncode, 1, second.stdout)
        after = self.jobs()
        self.assertEqual({job for job in after if after[job] != before[job]}, {'cut/replay.log'})
        self.assertEqual(self.results(), found)

        # One is mended, one is another recording now.
        bags[5].write_bytes(whole)
        shutil.copy(bags[1], bags[2])
        before = after
        earlier = self.folder / 'earlier'
        earlier.mkdir()
        text = (self.output / 'results.csv').read_text()
        (earlier / 'results.csv').write_text(re.sub(
            r'(?m)^(d,replay,unmatched),.*$', r'\1,-5', re.sub(
                r'(?m)^(b,replay,lost_percent),.*$', r'\1,100', text)))
        third = self.evaluate('--against', earlier)
        self.assertEqual(third.returncode, 0, third.stdout)
        after = self.jobs()
        self.assertEqual({job for job in after if after[job] != before[job]},
                         {'cut/replay.log', 'c/replay.log'})
        page = (self.output / 'index.html').read_text()
        self.assertIn('All recordings were measured.', page)
        changes = page[page.index('<h2>Changes</h2>'):page.index('<h2>Tables</h2>')]
        rows = re.findall(r'<tr class="(worse|better)"><td>([^<]*)</td>', changes)
        self.assertEqual(rows[0], ('worse', 'd'), changes)
        self.assertIn(('better', 'b'), rows)

    def test_wrong_use_is_named(self):
        (self.folder / 'list').write_text('a.bag colour=red\n')
        missing = self.evaluate('--config', 'none.yaml')
        self.assertEqual(missing.returncode, 2)
        self.assertIn('none.yaml: is no file', missing.stdout)
        (self.folder / 'list').write_text('a.bag labels=own red\n')
        wrong = self.evaluate()
        self.assertEqual(wrong.returncode, 2)
        self.assertIn('list:1: what is "red"? There are name=, ', wrong.stdout)
        self.assertFalse(self.output.exists())

    def test_names_stay_within_the_output(self):
        (self.folder / 'list').write_text(
            '../x/../../etc/passwd.bag\n"name with /" \nb.bag name=../../b\nb.bag name=..\nc/b.bag\n')
        names = list(recordings.read_list(str(self.folder / 'list')))
        self.assertEqual(names, ['passwd', 'name_with', 'b', 'recording', 'b_2'])

    def test_recordings_are_pooled_as_one(self):
        rows = {('a', 'detection'): {'frames': '10', 'demanded': '8', 'found': '4', 'false_boxes': '1',
                                     'recall': '0.5', 'mean_iou': '0.5', 'id_switches': '1'},
                ('b', 'detection'): {'frames': '30', 'demanded': '0', 'found': '0', 'false_boxes': '3',
                                     'recall': '', 'mean_iou': '0.9', 'id_switches': '2'}}
        found = {r.figure.column: r.value for r in figures.results_of(rows) if r.recording == 'all'}
        self.assertAlmostEqual(found['recall'], 0.5)
        self.assertAlmostEqual(found['precision'], 0.5)
        self.assertAlmostEqual(found['false_boxes_per_frame'], 0.1)
        self.assertAlmostEqual(found['mean_iou'], 0.8)
        self.assertEqual(found['id_switches'], 3)

    def test_what_became_worse_is_first(self):
        def results(recall, outliers, pairs, ms):
            keys = ('detection', 'recall'), ('disparity', 'd1_percent'), ('replay', 'pairs'), \
                ('replay', 'median_ms')
            return [figures.Result('a', figures.FIGURES[key], value)
                    for key, value in zip(keys, (recall, outliers, pairs, ms))]
        found = figures.changes(results(0.8, 4, 9, 10), results(0.4, 5, 7, 10.5))
        self.assertEqual([c.figure.column for c in found], ['recall', 'd1_percent'])
        self.assertAlmostEqual(found[0].worse, 0.5)
        self.assertAlmostEqual(figures.changes(results(0.4, 4, 9, 9), results(0.8, 4, 9, 9))[0].worse,
                               -0.5)


if __name__ == '__main__':
    if not shutil.which('snakemake'):
        print('skipped: snakemake is not installed')
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
