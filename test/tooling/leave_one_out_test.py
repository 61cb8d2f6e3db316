#!/usr/bin/python3
"""scripts/leave_one_out with a program that stands in for evaluate_detection.

Argument: the repository.
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(sys.argv[1]) / 'scripts/leave_one_out'
HEADER = 'sequence,group,frames,demanded,found,false_boxes'
# Found of 10, and false boxes, of three sequences. x=2 is best for all together and for the first
# two, but not for the third one, which alone would choose x=3.
COUNTS = {'': [(5, 0), (5, 0), (5, 0)], 'x=2': [(9, 0), (9, 0), (1, 3)], 
          'x=3': [(1, 0), (1, 0), (10, 0)]}
COUNTS['same=1'] = COUNTS['']
PROGRAM = """#!/usr/bin/python3
import sys
counts = %r
arguments = sys.argv[1:]
if 'broken' in arguments:
    sys.exit(2)
setting = arguments[arguments.index('--set') + 1] if '--set' in arguments else ''
with open(arguments[arguments.index('--csv') + 1], 'w') as out:
    out.write(%r)
    for name, (found, false_boxes) in zip('abc', counts[setting]):
        out.write('\\n%%s,all,4,10,%%d,%%d\\n%%s,toward,4,99,99,' %% (name, found, false_boxes, name))
    out.write('\\nall,all,12,30,1,1\\n')
""" % (COUNTS, HEADER)


class LeaveOneOut(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.dir = pathlib.Path(folder.name)
        program = self.dir / 'evaluate_detection'
        program.write_text(PROGRAM)
        program.chmod(0o755)

    def run_script(self, *arguments):
        return subprocess.run([str(SCRIPT), '--tools', str(self.dir), '--output', str(self.dir / 'out'),
                               *arguments], capture_output=True, text=True)

    def test_the_left_out_sequence_does_not_choose(self):
        done = self.run_script('--vary', 'x=2,3', '--', 'DATE', 'DRIVE')
        self.assertEqual(done.returncode, 0, done.stderr)
        table = (self.dir / 'out/table.md').read_text()
        rows = [[cell.strip() for cell in line.split('|')[1:-1]] for line in table.splitlines()[2:]]
        # Of b and c, x=3 finds 11 without a false box, x=2 10 with 3, the defaults 10.
        self.assertEqual(rows[0], ['a', '10', '0.50', '1.00', '0', 'x=3', '0.10', '1.00', '0'])
        self.assertEqual(rows[1], ['b', '10', '0.50', '1.00', '0', 'x=3', '0.10', '1.00', '0'])
        self.assertEqual(rows[2], ['c', '10', '0.50', '1.00', '0', 'x=2', '0.10', '0.25', '3'])
        self.assertEqual(rows[3], ['all', '30', '0.50', '1.00', '0', '', '0.10', '0.50', '3'])

    def test_the_defaults_win_a_tie(self):
        done = self.run_script('--vary', 'same=1', '--', 'DATE', 'DRIVE')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('| a | 10 | 0.50 | 1.00 | 0 | defaults |', done.stdout)

    def test_a_parameter_without_values(self):
        done = self.run_script('--vary', 'x=', '--', 'DATE', 'DRIVE')
        self.assertEqual(done.returncode, 2)
        self.assertIn('--vary x=: must be NAME=VALUE', done.stderr)

    def test_a_failed_run_leaves_no_figures(self):
        done = self.run_script('--vary', 'x=2', '--', 'broken')
        self.assertEqual(done.returncode, 2)
        self.assertIn('evaluate_detection failed with defaults', done.stderr)
        self.assertEqual(list((self.dir / 'out').glob('*.csv')), [])

    def test_what_is_measured_is_not_measured_again(self):
        self.run_script('--vary', 'x=2', '--', 'DATE', 'DRIVE')
        (self.dir / 'evaluate_detection').unlink()
        done = self.run_script('--vary', 'x=2', '--', 'DATE', 'DRIVE')
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.run_script('--vary', 'x=2', '--', 'DATE', 'OTHER')
        self.assertEqual(done.returncode, 2)
        self.assertIn('has figures of other arguments (DATE DRIVE)', done.stderr)


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
