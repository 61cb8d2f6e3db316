#!/usr/bin/python3
"""scripts/benchmark: tables, ranges, what it reads of the tools, and one section on a synthetic street.

Arguments: the repository, the build folder.
"""

import contextlib
import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

REPOSITORY, BUILD = pathlib.Path(sys.argv[1]), sys.argv[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(REPOSITORY / 'scripts/benchmark_tools'))
import page  # noqa: E402
import running  # noqa: E402
import sections  # noqa: E402

PAGE = 'before\n<!-- table: speed -->\nold\n<!-- end -->\nafter\n<!-- table: memory -->\n<!-- end -->\n'
PIPELINE = """2011_09_26_drive_0009_sync: 12 frames of 1242x375x128, 2 threads; mean search width 11.6 px

| per frame | median ms | whole pipeline is faster by |
|---|---:|---:|
| whole pipeline: ego-motion, disparity, moving objects | 25.00 | |
| OpenCV MODE_HH, disparity alone | 900.00 | 36.0 |
| OpenCV MODE_SGBM_3WAY, disparity alone | 42.50 | 1.7 |

stage                     median ms     p95 ms
ego-motion                     3.80       4.10
row alignment                  0.80       0.90
"""
LOAD = """51 pairs of 1242x375, 2 threads
asked Hz     sent     lost  counted reached Hz   p50 ms   p95 ms   p99 ms   max ms  memory MB
    10.0      100        0        0       10.1     26.1     36.8     40.2     47.4      250.0
     max      100        0        0       39.2     28.8     38.6     41.3     45.2      299.8
"""


class Canned(running.Runner):
    """Answers for every command with the same text."""

    def __init__(self, folder, answer):
        super().__init__(folder, folder, folder)
        self.answer = answer

    def _run(self, command, env):
        return self.answer


def benchmark(*arguments):
    environment = {name: value for name, value in os.environ.items() if name != 'KITTI_EXCERPTS'}
    return subprocess.run([str(REPOSITORY / 'scripts/benchmark'), '--build', BUILD] + list(arguments), env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, check=False)


class Benchmark(unittest.TestCase):

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix='benchmark_')
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def speed(self):
        return sections.measure('speed', Canned(self.folder, PIPELINE))

    def test_a_table_takes_its_place_in_the_page(self):
        table = page.Table('speed', 'row', ['a', 'b'], ['tool --x'])
        table.add('one', [1.234, None], [1, 2])
        self.assertEqual(page.filled(PAGE, [table]), PAGE.replace(
            'old\n', '| row | a | b |\n|---|---:|---:|\n| one | 1.2 |  |\n\n`tool --x`\n'))
        with self.assertRaisesRegex(ValueError, '0 markers for table other'):
            page.filled(PAGE, [page.Table('other', '', [])])

    def test_what_tools_print_becomes_figures(self):
        table = self.speed()
        figures = table.figures()
        self.assertEqual(figures['whole pipeline, ms', '2 threads'], 25)
        self.assertEqual(figures['stage: row alignment, ms', '1 thread'], 0.8)
        self.assertAlmostEqual(figures['times faster than MODE_SGBM_3WAY', '2 threads'], 1.7)
        self.assertEqual(len(table.commands), 2)

    def test_reads_the_rates_of_load_test(self):
        with unittest.mock.patch.object(running, 'roscore', lambda log: contextlib.nullcontext({})):
            figures = sections.measure('latency', Canned(self.folder, LOAD)).figures()
        self.assertEqual(figures['10.0', 'p50 ms'], 26.1)
        self.assertEqual(figures['as fast as nothing is lost', 'reached Hz'], 39.2)
        self.assertEqual(figures['as fast as nothing is lost', 'memory MB'], 299.8)

    def test_another_output_is_an_error(self):
        with self.assertRaisesRegex(running.ToolFailed, 'something else than expected'):
            sections.measure('speed', Canned(self.folder, '| per frame | median ms |\n| x | 1 |\n\nstage  ms\na  1\n'))

    def test_says_what_left_its_range(self):
        ratio, column = 'times faster than MODE_SGBM_3WAY', '2 threads'
        table = [self.speed()]
        self.assertEqual(page.out_of_range({('speed', ratio, column): (1.5, 2)}, table), [])
        self.assertEqual(page.out_of_range({('speed', ratio, column): (1.8, 2)}, table),
                         ['speed / %s / %s = 1.7, expected 1.8 to 2' % (ratio, column)])
        self.assertEqual(page.out_of_range({('speed', 'gone', column): (0, 1)}, table),
                         ['speed / gone / 2 threads was not measured'])
        self.assertEqual(page.out_of_range({('memory', 'gone', column): (0, 1)}, table), [])

    def test_a_recording_that_is_not_there_is_left_out(self):
        table = page.Table('near_objects', '', sections.OBJECT_COLUMNS)
        table.add_absent('people, both')
        column = sections.OBJECT_COLUMNS[1]
        self.assertEqual(page.out_of_range({('near_objects', 'people, both', column): (0, 1)}, [table]), [])
        benchmarks = (REPOSITORY / 'docs/benchmarks.md').read_text()
        readme = page.summarised((REPOSITORY / 'README.md').read_text(), page.filled(benchmarks, [table]))
        self.assertNotIn('people at 0.8 to 2 m', readme)
        self.assertIn('moving objects, synthetic streets', readme)

    def test_the_shipped_ranges_and_the_page_fit_the_sections(self):
        ranges = page.read_ranges(str(REPOSITORY / 'scripts/benchmark_tools/expected.csv'))
        self.assertGreater(len(ranges), 20)
        self.assertEqual({table for table, _, _ in ranges} - set(sections.SECTIONS), set())
        text = (REPOSITORY / 'docs/benchmarks.md').read_text()
        for name in sections.SECTIONS:
            self.assertEqual(text.count('<!-- table: %s -->' % name), 1, name)

    def test_missing_input_is_named(self):
        result = benchmark('--only', 'speed', '--out', self.folder)
        self.assertEqual(result.returncode, 2, result.stdout)
        self.assertIn('2011_09_26/2011_09_26_drive_0009_sync: give --kitti FOLDER', result.stdout)
        result = benchmark('--only', 'speed', '--kitti', self.folder, '--out', self.folder)
        self.assertIn('there is none in --kitti ' + self.folder, result.stdout)
        result = benchmark('--only', 'sped', '--out', self.folder)
        self.assertEqual(result.returncode, 2)
        self.assertIn('there is no such section', result.stdout)

    def test_a_section_on_a_synthetic_street(self):
        result = benchmark('--only', 'streets', '--quick', '--out', self.folder)
        self.assertEqual(result.returncode, 0, result.stdout)
        with open(os.path.join(self.folder, 'figures.csv'), newline='') as file:
            figures = {(line['row'], line['column']): float(line['value']) for line in csv.DictReader(file)}
        self.assertGreater(figures['**ours**', 'turn density'], 80)
        self.assertLess(figures['**ours**', 'turn D1'], 10)
        with open(os.path.join(self.folder, 'benchmarks.md')) as file:
            self.assertIn('| **ours** | %.2f' % figures['**ours**', 'turn D1'], file.read())


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
