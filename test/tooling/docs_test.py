#!/usr/bin/python3
"""README.md, CONTRIBUTING.md and docs/ agree with the package: what they name exists, and each topic is in them.

Arguments: the repository, a folder with the tools.
"""

import functools
import importlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY, TOOLS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
PAGES = [REPOSITORY / 'README.md', REPOSITORY / 'CONTRIBUTING.md'] + sorted((REPOSITORY / 'docs').glob('*.md'))
SECTIONS = ('ego_motion', 'disparity', 'moving_objects', 'rectify')
# Options of programs that are not ours.
FOREIGN_OPTIONS = {
    '--approximate', '--benchmark_filter', '--build', '--default-resources', '--from-paths', '--ignore-src', '--install',
    '--no-install-recommends', '--square', '--target',
}
SCRIPTS = [path for path in (REPOSITORY / 'scripts').iterdir() if path.is_file() and os.access(path, os.X_OK)]
SCRIPTS += [REPOSITORY / 'test/tooling/fresh_root', REPOSITORY / 'test/fuzz/run']


def text(page):
    return page.read_text()


def code(page):
    """What stands in backquotes or in indented or fenced blocks."""
    content = text(page)
    blocks = re.findall(r'^```.*?\n(.*?)^```', content, re.DOTALL | re.MULTILINE)
    blocks += re.findall(r'^    .*$', content, re.MULTILINE)
    return blocks + re.findall(r'`([^`\n]+)`', content)


@functools.lru_cache(maxsize=None)
def output(*command):
    return subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          universal_newlines=True, check=False).stdout


@functools.lru_cache(maxsize=None)
def parameters():
    """Full names: those of all nodelets, and those of rectify."""
    lines = output(TOOLS / 'replay', '--parameters').splitlines()
    names, path = set(), []
    for line in lines:
        found = re.match(r'( *)([a-z0-9_]+):', line)
        if not found:
            continue
        depth = len(found.group(1)) // 2
        path = path[:depth] + [found.group(2)]
        names.add('/'.join(path))
    return names


def benchmark_page():
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(REPOSITORY / 'scripts/benchmark_tools'))
    return importlib.import_module('page')


def tools():
    """Programs of the package: those whose source is in a folder tools, and the benchmarks."""
    names = {path.stem for path in (REPOSITORY / 'src').rglob('tools/*.cpp') if 'runProgram' in path.read_text()}
    return {name for name in names if (TOOLS / name).exists()}


def headings(page):
    """Anchors of the headings, as GitHub makes them."""
    anchors = set()
    for heading in re.findall(r'^#+ (.*)$', text(page), re.MULTILINE):
        plain = re.sub(r'\[([^]]*)\]\([^)]*\)', r'\1', heading).replace('`', '')
        anchors.add(re.sub(r'[^\w\- ]', '', plain.lower()).replace(' ', '-'))
    return anchors


class Docs(unittest.TestCase):

    def test_links_resolve(self):
        wrong = []
        for page in PAGES:
            for target in re.findall(r'\]\(([^)\s]+)\)', text(page)):
                if re.match(r'[a-z]+:', target):
                    continue
                path, _, anchor = target.partition('#')
                file = (page.parent / path).resolve() if path else page
                if not file.exists():
                    wrong.append('%s: %s' % (page.name, target))
                elif anchor and anchor not in headings(file):
                    wrong.append('%s: %s has no such heading' % (page.name, target))
        self.assertEqual(wrong, [])

    def test_every_file_is_on_the_map(self):
        """Section "Which file" names each file of src/ but inner loops, and none that is not there."""
        page = text(REPOSITORY / 'docs/architecture.md')
        section = re.search(r'^## Which file$(.*?)^## ', page, re.DOTALL | re.MULTILINE).group(1)
        named = set()
        for folders, files in re.findall(r'^\| (`.*?) \| (.*) \|$', section, re.MULTILINE):
            folder = re.match('`([a-z/]+)`', folders).group(1)
            named |= {'%s/%s' % (folder, name) for name in re.findall(r'`([a-z0-9_-]+)`', files)}
        there = {str(path.relative_to(REPOSITORY / 'src').with_suffix('')) for path in (REPOSITORY / 'src').rglob('*/*.*')}
        loops = {name for name in there if re.search('_(rows|kernels?)$', name)}
        shared = {name for name in there if re.search('_(nodelet|processor)$', name)}  # a row says NAME_...
        self.assertEqual(sorted(there - loops - shared - named), [], 'not on the map')
        self.assertEqual(sorted(named - there), [], 'there is no such file')

    def test_parameters_exist(self):
        self.assertIn('disparity/matcher/p1', parameters())
        wrong = []
        for page in PAGES:
            for piece in code(page):
                for name in re.findall(r'(?<![\w/.])((?:%s)/[a-z0-9_/]+)' % '|'.join(SECTIONS), piece):
                    name = name.rstrip('/')
                    if name not in parameters() and not self.is_other(name):
                        wrong.append('%s: %s' % (page.name, name))
        self.assertEqual(wrong, [], 'neither a parameter, nor a topic, nor a file')

    def is_other(self, name):
        return (name in topics() or
                any(topic.startswith(name + '/') for topic in topics()) or
                any((REPOSITORY / 'src' / (name + end)).exists() for end in ('', '.cpp', '.h')))

    def test_topics_are_documented(self):
        self.assertIn('disparity_variance', topics())
        reference = text(REPOSITORY / 'docs/nodes.md')
        self.assertEqual([topic for topic in sorted(topics()) if '`%s`' % topic not in reference], [])

    def test_figures_of_readme_are_those_of_the_benchmarks(self):
        readme = text(REPOSITORY / 'README.md')
        self.assertIn('<!-- summary -->', readme)
        self.assertEqual(readme, benchmark_page().summarised(readme, text(REPOSITORY / 'docs/benchmarks.md')))

    def test_tables_say_which_code_is_newer(self):
        """A line "- Newer than the tables: `FOLDER`, ..." names exactly the stages that changed since they were measured."""
        benchmarks = text(REPOSITORY / 'docs/benchmarks.md')
        line = re.search(r'^- Newer than the tables: (.*)$', benchmarks, re.MULTILINE)
        said = set(re.findall('`([a-z]+)`', line.group(1))) if line else set()
        self.assertEqual(benchmark_page().newer_stages(benchmarks, REPOSITORY), said)

    def test_reference_is_up_to_date(self):
        self.assertEqual(output(REPOSITORY / 'scripts/make_reference', '--check'), '')

    @unittest.skipUnless(shutil.which('doxygen'), 'doxygen is not installed')
    def test_public_headers_make_api_pages(self):
        with tempfile.TemporaryDirectory() as folder:
            options = (REPOSITORY / 'docs/Doxyfile').read_text() + '\nOUTPUT_DIRECTORY = ' + folder
            run = subprocess.run(['doxygen', '-'], input=options, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 universal_newlines=True, cwd=str(REPOSITORY), check=False)
            self.assertEqual((run.returncode, run.stdout), (0, ''))
            self.assertTrue(list(pathlib.Path(folder).glob('api/class*Pipeline.html')))

    def test_tools_are_documented(self):
        self.assertIn('replay', tools())
        documented = ' '.join(text(page) for page in PAGES)
        self.assertEqual([tool for tool in tools() if not re.search(r'\b%s\b' % tool, documented)], [])

    def test_messages_are_documented(self):
        documented = ' '.join(text(page) for page in PAGES)
        names = [path.stem for path in (REPOSITORY / 'msg').glob('*.msg')]
        self.assertEqual([name for name in names if name != 'BoundingBox2D' and name not in documented], [])

    def test_options_exist(self):
        """Each --option that a page names is in the help of one of our programs."""
        helps = ' '.join(output(TOOLS / tool, '--help') for tool in sorted(tools()))
        helps += ' '.join(path.read_text() for path in (REPOSITORY / 'test/benchmark').glob('*.cpp'))
        helps += ' '.join(output(script, '--help') for script in SCRIPTS)
        known = set(re.findall(r'--[a-z][a-z0-9_-]*', helps)) | FOREIGN_OPTIONS
        self.assertIn('--perturb', known)
        wrong = ['%s: %s' % (page.name, option) for page in PAGES for piece in code(page)
                 for option in re.findall(r'(?<![\w-])--[a-z][a-z0-9_-]*', piece) if option not in known]
        self.assertEqual(wrong, [])

    def test_options_of_commands_exist(self):
        """In a command of one of our tools, each option is one of that tool."""
        wrong = []
        for page in PAGES:
            for piece in code(page):
                for line in piece.replace('\\\n', ' ').splitlines():
                    found = re.match(r'\s*(?:rosrun predictive_stereo )?([a-z_]+) (.*)', line.split('#')[0])
                    if not found or found.group(1) not in tools():
                        continue
                    known = set(re.findall(r'--[a-z][a-z0-9-]*', output(TOOLS / found.group(1), '--help')))
                    known |= {'--help', '--parameters'}
                    wrong += ['%s: %s %s' % (page.name, found.group(1), option) for option in
                              re.findall(r'(?<![\w-])--[a-z][a-z0-9-]*', found.group(2)) if option not in known]
        self.assertEqual(wrong, [])

    def test_launch_arguments_exist(self):
        declared = set(re.findall(r'<arg name="(\w+)"', ' '.join(
            path.read_text() for path in (REPOSITORY / 'launch').rglob('*.launch'))))
        wrong = []
        for page in [REPOSITORY / 'README.md', REPOSITORY / 'docs/using.md']:
            for piece in code(page):
                if 'rosrun' in piece or 'rostest' in piece:
                    continue
                wrong += ['%s: %s:=' % (page.name, name) for name in re.findall(r'(?<![\w/])([a-z]\w*):=', piece)
                          if name not in declared]
        self.assertEqual(wrong, [])


@functools.lru_cache(maxsize=None)
def topics():
    """Topics that the nodelets advertise, without namespaces."""
    names = set()
    folder = REPOSITORY / 'src/nodelets'
    for source in [*folder.glob('*_nodelet.cpp'), folder / 'output_topics.h']:
        text = source.read_text()
        names |= set(re.findall(r'\(\{"([a-z0-9_/]+)"', text))
        for call in re.findall(r'advertise\w*(?:<[^;(]*?>)?\(([^;]*?)\)', text, re.DOTALL):
            names |= set(re.findall(r'"([a-z0-9_/]+)"', call))
    masks = (REPOSITORY / 'src/nodelets/stereo_messages.h').read_text()
    return names | set(re.findall(r'k\w*MaskTopic\[\] = "([a-z_/]+)"', masks))


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
