#!/usr/bin/python3
"""Who includes what: the sources keep to the table of docs/architecture.md.

Argument: the repository.
"""

import pathlib
import re
import sys
import unittest

REPOSITORY = pathlib.Path(sys.argv[1])
SOURCES = sorted(path for path in (REPOSITORY / 'src').rglob('*') if path.suffix in ('.h', '.cpp'))
PUBLIC = 'predictive_stereo'
ROS = re.compile(r'<(ros|rosbag|roscpp|nodelet|tf2\w*|\w+_msgs|cv_bridge|image_transport|diagnostic_updater)/')
WITH_ROS = ('nodelets', 'tools', 'evaluation/tools')


def table():
    """Rows "| `folder` | does | `folder`, ... |" of section "Folders": what each folder may include."""
    page = (REPOSITORY / 'docs/architecture.md').read_text()
    section = re.search(r'^## Folders$(.*?)^## ', page, re.DOTALL | re.MULTILINE).group(1)
    rows = re.findall(r'^\| `([a-z/]+)` \| [^|]* \| ([^|]*)\|$', section, re.MULTILINE)
    return {folder: re.findall('`([a-z/]+)`', may) for folder, may in rows}


def included(source):
    """Folders whose headers a file includes, or compiles again for a SIMD target."""
    lines = re.findall(r'^ *# *(?:include|define HWY_TARGET_INCLUDE) "([^"]+)"', source.read_text(), re.MULTILINE)
    return [line.rpartition('/')[0] for line in lines]


def folder_of(path):
    return str(path.parent.relative_to(REPOSITORY / 'src'))


class Includes(unittest.TestCase):

    def test_every_folder_is_in_the_table(self):
        self.assertEqual(sorted({folder_of(path) for path in SOURCES}), sorted(table()))

    def test_sources_keep_to_the_table(self):
        wrong = []
        for path in SOURCES:
            may = table()[folder_of(path)] + [folder_of(path), PUBLIC]
            wrong += ['%s includes %s' % (path.relative_to(REPOSITORY), folder)
                      for folder in included(path) if folder not in may]
        self.assertEqual(wrong, [])

    def test_the_table_allows_only_what_is_used(self):
        used = {folder: set() for folder in table()}
        for path in SOURCES:
            used[folder_of(path)].update(included(path))
        idle = ['%s never includes %s' % (folder, other)
                for folder, may in table().items() for other in may if other not in used[folder]]
        self.assertEqual(idle, [])

    def test_no_arrow_runs_back_up(self):
        """A folder includes only folders above its row."""
        order = list(table())
        wrong = ['%s includes %s' % (folder, other) for folder, may in table().items() for other in may
                 if order.index(other) >= order.index(folder)]
        self.assertEqual(wrong, [])

    def test_public_headers_include_only_each_other(self):
        for path in (REPOSITORY / 'include').rglob('*.h'):
            self.assertLessEqual(set(included(path)), {PUBLIC}, path.name)

    def test_ros_stays_in_its_folders(self):
        wrong = [str(path.relative_to(REPOSITORY)) for path in SOURCES
                 if folder_of(path) not in WITH_ROS and ROS.search(path.read_text())]
        self.assertEqual(wrong, [])


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
