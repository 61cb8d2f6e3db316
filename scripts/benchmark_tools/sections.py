"""The sections of docs/benchmarks.md: each runs tools and makes one table."""

import collections
import os
import platform
import re
import subprocess

import running
from page import Table, sums_of_stages
from running import find, number

DAY, OTHER_DAY = '2011_09_26', '2011_09_30'
DRIVE = '2011_09_26_drive_%04d_sync'
DRIVE_0020 = '2011_09_30_drive_0020_sync'
KITTI_2012, KITTI_2015 = 'stereo_flow_2012/training', 'scene_flow_2015/training'
DRIVES = [DAY, DRIVE % 9, DRIVE % 2]
REPOSITORY = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
LABELS = 'test/data/labels'  # in the repository

Section = collections.namedtuple('Section', 'function needs')
SECTIONS = collections.OrderedDict()


def section(*needs):
    def register(function):
        SECTIONS[function.__name__] = Section(function, needs)
        return function
    return register


def measure(name, run):
    """The table of a section."""
    run.take_commands()
    try:
        table = SECTIONS[name].function(run)
    except (IndexError, KeyError, TypeError, ValueError) as error:
        raise running.ToolFailed('a tool printed something else than expected, see the logs: %r' % error) from error
    table.commands = run.take_commands()
    return table


def _drive(number):
    return '%s/%s' % (DAY, DRIVE % number)


def _output(*command):
    try:
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                              check=False).stdout.strip()
    except OSError:
        return ''


def _cached(run, name):
    """A variable of CMake's cache."""
    try:
        with open(os.path.join(run.tools, '../../../CMakeCache.txt')) as file:
            found = re.search(r'^%s:\w+=(.*)$' % name, file.read(), re.MULTILINE)
    except OSError:
        return ''
    return found.group(1) if found else ''


def _cpu():
    """Its name, and what tells models of the same name apart, as on a virtual machine."""
    with open('/proc/cpuinfo') as file:
        cpu = dict(re.findall(r'^([\w ]+?)\s*: (.*)$', file.read(), re.MULTILINE))
    if 'model name' not in cpu or 'cpu MHz' not in cpu:
        return platform.machine()
    return '%s (family %s, model %s, %.1f GHz%s)' % (
        cpu['model name'], cpu['cpu family'], cpu['model'], float(cpu['cpu MHz']) / 1000,
        ', virtual' if 'hypervisor' in cpu['flags'].split() else '')


@section('tool:replay')
def machine(run):
    """What the figures were measured with."""
    with open('/etc/os-release') as file:
        system = re.search(r'PRETTY_NAME="(.*)"', file.read())
    compiler = _output(_cached(run, 'CMAKE_CXX_COMPILER') or 'c++', '-dumpfullversion')
    table = Table('machine', '', [''])
    table.add('commit', [_output('git', '-C', REPOSITORY, 'describe', '--always', '--dirty') or 'unknown'])
    table.add('code', [', '.join('%s %s' % item for item in sums_of_stages(REPOSITORY).items())])
    table.add('date', [_output('date', '+%Y-%m-%d')])
    table.add('CPU', ['%s, %d cores' % (_cpu(), os.cpu_count())])
    table.add('system', ['%s, compiler %s' % (system.group(1) if system else platform.system(), compiler)])
    table.add('OpenCV', [_output('pkg-config', '--modversion', 'opencv4') or 'unknown'])
    return table


SPEED = collections.OrderedDict([
    ('whole pipeline: ego-motion, disparity, moving objects', 'whole pipeline'),
    ('OpenCV MODE_SGBM_3WAY, disparity alone', 'OpenCV MODE_SGBM_3WAY, disparity alone'),
    ('OpenCV MODE_HH, disparity alone', 'OpenCV MODE_HH, disparity alone')])


@section('tool:benchmark_pipeline', _drive(9))
def speed(run):
    """Time of a frame, and of its stages, beside OpenCV's."""
    times, stages = [], []
    for threads in '2', '1':
        text = run.text('benchmark_pipeline', DAY, DRIVE % 9, '--rounds', '1', '--frames',
                        run.few('12', '2'), '--threads', threads)
        times.append({row[0]: number(row[1]) for row in running.markdown_tables(text)[0][1:]})
        stages.append({name: number(cells[0]) for name, cells in
                       running.columns(text, 'stage  ').items()})
    table = Table('speed', 'per frame, median', ['2 threads', '1 thread'])
    for name, label in SPEED.items():
        table.add(label + ', ms', [one[name] for one in times], 1)
    for name in list(SPEED)[1:]:
        table.add('times faster than %s' % name.split()[1].rstrip(','),
                  [one[name] / one[list(SPEED)[0]] for one in times], 1)
    for name in stages[0]:
        table.add('stage: %s, ms' % name, [one[name] for one in stages], 1)
    return table


@section('tool:work_and_span', _drive(9))
def cores(run):
    """Predicted time of a frame on more cores than there are."""
    text = run.text('work_and_span', DAY, DRIVE % 9, *(['--frames', '2', '--rounds', '1'] if run.quick
                                                        else []))
    totals = running.markdown_tables(text)[0]
    heads = totals[0]
    table = Table('cores', 'ms on so many cores', [row[0] for row in totals[1:]])
    table.add('whole frame', [number(row[1]) for row in totals[1:]])
    table.add('of it serial', [number(row[heads.index('serial ms')]) for row in totals[1:]])
    table.add('share of the time on one core',
              [number(row[1]) / number(totals[1][1]) for row in totals[1:]])
    return table


@section('tool:benchmark_matchers')
def growth(run):
    """How the time of the searches grows; synthetic street, one thread."""
    options = ['--frames', '1', '--rounds', run.few('5', '1')]
    text = run.text('benchmark_matchers', *options, *(['--size', '480x160'] if run.quick else []))
    table = Table('growth', 'one search, one thread', ['full, ms', 'reduced, ms'])
    for rows in running.markdown_tables(text):
        head = rows[0][0]
        if head == 'image':
            for row in rows[1::2]:
                table.add('image ' + row[0], [number(row[1]), number(row[2])], 1)
        elif head == 'disparities':
            for row in rows[1:]:
                if row[0] in ('64', '256'):
                    table.add('%s disparities' % row[0], [number(row[1]), number(row[2])], 1)
        elif head == 'width asked for':
            for row in rows[1:]:
                if row[0] in ('32', '128'):
                    table.add('reduced to %s disparities a pixel' % row[0], [None, number(row[2])], 1)
    return table


METHODS = collections.OrderedDict([
    ('opencv_hh', 'OpenCV MODE_HH'), ('opencv_hh_aligned', 'OpenCV MODE_HH, rows aligned'),
    ('opencv_3way', 'OpenCV MODE_SGBM_3WAY'), ('ours', '**ours**'),
    ('ours_full', 'ours, full search in every frame'), ('ours_8', 'ours, 8 paths')])


def _accuracy_rows(run):
    frames = ['--frames', '3'] if run.quick else []
    rows, text = run.csv('evaluate_kitti', *DRIVES, '--kitti2012', KITTI_2012, '--methods',
                         ','.join(run.few(list(METHODS), ['opencv_3way', 'ours'])), *frames,
                         name='accuracy')
    return rows, text


def _sequences(rows):
    """Names of sequences in the order of the file."""
    return list(dict.fromkeys(row['sequence'] for row in rows))


def _short(name):
    found = re.search(r'_drive_0*(\d+)_sync', name)
    return '%04d' % int(found.group(1)) if found else ('KITTI 2012' if '2012' in name else
                                               name.replace('street ', '', 1))


def _accuracy_table(name, rows):
    sequences = _sequences(rows)
    table = Table(name, '%', ['%s %s' % (_short(s), column) for s in sequences
                              for column in ('D1', 'D1f', 'density')])
    for method, label in METHODS.items():
        values = []
        for sequence in sequences:
            found = [row for row in rows if (row['sequence'], row['method']) == (sequence, method)]
            values += [number(found[0][key]) for key in
                       ('d1_percent', 'd1f_percent', 'density_percent')] if found else [None] * 3
        if any(value is not None for value in values):
            table.add(label, values, [2, 2, 1] * len(sequences))
    return table


@section('tool:evaluate_kitti', _drive(9), _drive(2), KITTI_2012)
def accuracy(run):
    """Disparities of KITTI's drives and KITTI 2012."""
    return _accuracy_table('accuracy', _accuracy_rows(run)[0])


@section('tool:evaluate_kitti')
def streets(run):
    """Disparities of synthetic streets."""
    rows, _ = run.csv('evaluate_kitti', '--street', 'turn', '--street', 'street', '--street-frames',
                      run.few('16', '3'), '--methods', run.few('opencv_hh,ours,ours_full', 'ours'),
                      name='streets')
    return _accuracy_table('streets', rows)


def _triples(text, title, method):
    """all / background / vehicles of a method, for each column."""
    cells = running.columns(text, title).get(method)
    if cells is None:
        raise running.ToolFailed("'%s' has no row %s" % (title, method))
    return [[number(value) for value in cell.split(' / ')] for cell in cells[1:]]


@section('tool:evaluate_kitti', KITTI_2015)
def kitti2015(run):
    """Disparities of KITTI 2015, counted as its devkit does."""
    methods = run.few('opencv_hh,ours,ours_full', 'ours')
    single = _kitti2015_text(run)
    table = Table('kitti2015', '%', ['%s, %s' % (what, region) for what in
                                     ('D1 interpolated', 'D1 of valid pixels', 'density')
                                     for region in ('all', 'background', 'vehicles')])
    digits = [2] * 6 + [1] * 3
    for method in methods.split(','):
        table.add(METHODS[method], sum(_triples(single, 'KITTI 2015, ', method), []), digits)
    text = run.text('evaluate_kitti', '--kitti2015', KITTI_2015, '--kitti2015-as-sequence', '--methods', 'ours',
                    *run.few([], ['--frames', '3']))
    table.add('ours, as one sequence', sum(_triples(text, 'KITTI 2015', 'ours'), []), digits)
    return table


def _kitti2015_text(run):
    return run.text('evaluate_kitti', '--kitti2015', KITTI_2015, '--methods',
                    run.few('opencv_hh,ours,ours_full', 'ours'), *run.few([], ['--frames', '3']))


def _times(factor, value):
    return None if value is None else factor * value


@section('tool:evaluate_kitti', _drive(9), _drive(2), KITTI_2012, KITTI_2015)
def variance(run):
    """Whether errors agree with the published variance."""
    rows, text = _accuracy_rows(run)
    sequences = _sequences(rows)
    ours = [find(rows, sequence=sequence, method='ours') for sequence in sequences]
    table = Table('variance', 'ours', [_short(sequence) for sequence in sequences] + ['KITTI 2015'])
    pixels = running.columns(_kitti2015_text(run), 'Variance of ours').get('all')
    for index, sigmas in enumerate(('1', '2', '3')):
        table.add('errors within %s sigma, %%' % sigmas,
                  [_times(100, number(row['within_%s_sigma' % sigmas])) for row in ours] +
                  [number(pixels[index])], 1)
    table.add('mean sigma, px', [number(row['mean_sigma_px']) for row in ours] + [number(pixels[3])])
    table.add('negative log-likelihood', [number(row['nll']) for row in ours] + [None])
    table.add('rms error of inliers, filtered / measured',
              [_times(1 / (number(row['measured_rms_px']) or 1), number(row['rms_px'])) for row in ours] +
              [None], 3)
    table.add('mean search width, px', [number(row['mean_width_px']) for row in ours] + [None], 1)
    return table


@section('tool:evaluate_kitti', KITTI_2015)
def certainty(run):
    """How well ours and OpenCV's left-right difference know which disparities are wrong."""
    table = Table('certainty', 'KITTI 2015', ['mean error, px', 'AUSE, px', 'AUSE of a random order, px', 'AUSE / random'])
    rows = running.columns(_kitti2015_text(run), 'Certainty')
    for method in run.few(['opencv_hh', 'ours'], ['ours']):
        table.add(METHODS[method], [number(cell) for cell in rows[method]], [2, 3, 3, 2])
    return table


# Scenes and their numbers of frames.
EGO_MOTION = [('street', 40), ('crowded', 40), ('near_half_moves', 30), ('highway', 40), ('robot', 60),
              ('handheld', 60), ('drone', 60), ('standstill', 200)]


@section('tool:evaluate_odometry', '%s/%s' % (OTHER_DAY, DRIVE_0020))
def ego_motion(run):
    """Errors of the motion between frames, and of the path."""
    table = Table('ego_motion', '', ['frames', 'm per frame', 'degrees per frame', 'path length, %',
                                     'relative errors, %', "e'C^-1e / 6", 'lost'])
    rows, _ = run.csv('evaluate_odometry', OTHER_DAY, DRIVE_0020, *run.few([], ['--frames', '4']),
                      name='odometry_0020')
    streets = []
    for scene, frames in run.few(EGO_MOTION, [('street', 4)]):
        more, _ = run.csv('evaluate_odometry', '--street', scene, '--street-frames', str(frames),
                          name='odometry_' + scene,
                          shown='evaluate_odometry --street SCENE --street-frames FRAMES')
        streets.append((scene, more[0]))
    for label, row in [('KITTI 0020', rows[0])] + streets:
        # KITTI's poses jitter by more than the covariance has it.
        agreement = None if label == 'KITTI 0020' else number(row['mean_normalized_error'])
        table.add(label, [int(row['motions']) + 1, number(row['translation_error_m']),
                          number(row['rotation_error_deg']), number(row['length_error_percent']),
                          number(row['translation_error_percent']), agreement, int(row['lost'])],
                  [0, 4, 4, 2, 2, 2, 0])
    return table


OBJECT_COLUMNS = ['frames', 'objects', 'recall, IoU 0.3', 'precision, IoU 0.3', 'recall, IoU 0.5',
                  'precision, IoU 0.5', 'false boxes per frame']
OBJECT_DIGITS = [0, 0, 2, 2, 2, 2, 3]


def _detection(run, *arguments):
    """What evaluate_detection prints of recordings with our labels."""
    return run.text('evaluate_detection', *arguments, '--labels', os.path.join(REPOSITORY, LABELS),
                    shown=' '.join(['evaluate_detection', *arguments, '--labels', LABELS]))


def _object_rows(text, names):
    """(label, figures) of each recording that is named; names: label -> how the program names it."""
    pooled = running.columns(text, 'recall and precision at IoU')
    for label, name in names.items():
        yield label, [number(cell) for cell in pooled[name][:len(OBJECT_COLUMNS)]]


@section('tool:evaluate_detection', _drive(1), _drive(2), _drive(9), '%s/%s' % (OTHER_DAY, DRIVE_0020), KITTI_2012)
def moving_objects(run):
    """Recall and precision of moving objects in KITTI's drives."""
    table = Table('moving_objects', '', OBJECT_COLUMNS)
    text = _detection(run, DAY, DRIVE % 1, DRIVE % 2, DRIVE % 9, OTHER_DAY, DRIVE_0020, '--kitti2012', KITTI_2012,
                      '--perturb', *run.few([], ['--frames', '4']))
    names = {'KITTI %04d' % drive: DRIVE % drive for drive in (1, 2, 9)}
    # KITTI 2012's scenes have no objects, and count with all.
    for label, figures in _object_rows(text, {**names, 'KITTI 0020': DRIVE_0020, 'KITTI, all': 'all'}):
        table.add(label, figures, OBJECT_DIGITS)
    mean = running.columns(text, 'all sequences under perturbations')['mean +- spread']
    table.add('KITTI, mean over perturbations', [None, None] + [number(cell) for cell in mean[-5:]], OBJECT_DIGITS)
    return table


# Recordings of near objects. Those that nobody can download are measured where they lie beside the KITTI data.
NEAR = [('KITTI 0013, a car overtakes at 4 to 9 m', DAY, DRIVE % 13),
        ('people at 1.2 to 2 m, seen from above', '../people/2021_01_01', '2021_01_01_drive_0001_sync'),
        ('a person at 0.8 to 2 m', '../people/2025_04_12', '2025_04_12_drive_0001_sync'),
        ('a drone at rest, nothing moves', '../euroc/2014_06_25', 'V1_01_easy_head_sync')]


@section('tool:evaluate_detection', _drive(13))
def near_objects(run):
    """Recall and precision of moving objects near the camera."""
    table = Table('near_objects', '', OBJECT_COLUMNS)
    found = [entry for entry in NEAR if os.path.exists(os.path.join(run.kitti, entry[1], entry[2]))]
    text = _detection(run, *[word for entry in found for word in entry[1:]], *run.few([], ['--frames', '4']))
    for label, figures in _object_rows(text, {label: drive for label, _, drive in found}):
        table.add(label, figures, OBJECT_DIGITS)
    for label, _, _ in (entry for entry in NEAR if entry not in found):
        table.add_absent(label)
    people = [word for entry in found if 'people' in entry[1] for word in entry[1:]]
    if not people:
        table.add_absent('people, both')
        return table
    pooled = _detection(run, *people, *run.few([], ['--frames', '4']))
    for label, figures in _object_rows(pooled, {'people, both': 'all'}):
        table.add(label, figures, OBJECT_DIGITS)
    return table


CLIPS = ['street', 'straight', 'turn', 'brake', 'standstill', 'static', 'fast_rotation', 'leader', 'crowded',
         'near_half_moves', 'misaligned']
PEOPLE_CLIPS = ['people_standing', 'people_slow']
CLIP_SEEDS = ['201', '202', '215', '216', '217', '218']  # no parameter was set by these clips


@section('tool:evaluate_detection', 'tool:street_to_bag')
def synthetic_objects(run):
    """Recall and precision of moving objects in synthetic clips."""
    table = Table('synthetic_objects', '', OBJECT_COLUMNS)
    seeds = run.few(CLIP_SEEDS, CLIP_SEEDS[:1])
    for what, scenes, frames in (('%d scenes' % len(CLIPS), run.few(CLIPS, ['straight', 'turn']), '20'),
                                 ('people at 0.8 to 6 m', PEOPLE_CLIPS, '60')):
        bags = [_clip(run, scene, frames, seed) for scene in scenes for seed in seeds]
        text = run.text('evaluate_detection', *bags, shown='evaluate_detection *.bag')
        for _, figures in _object_rows(text, {'': 'all'}):
            table.add('%s, test seeds' % what, figures, OBJECT_DIGITS)
    return table


def _clip(run, scene, frames, seed):
    bag = run.path('%s_%s.bag' % (scene, seed))
    run.text('street_to_bag', bag, '--scene', scene, '--frames', run.few(frames, '4'), '--seed', seed,
             shown='street_to_bag SCENE_SEED.bag --scene SCENE --frames %s --seed SEED' % frames)
    return bag


MEMORY = [('full search', 'matchFull/straight_4'), ('reduced search', 'matchReduced/straight_4'),
          ('disparity loop', 'disparityLoop'), ('whole pipeline', 'wholePipeline')]


@section('tool:benchmark_stages')
def memory(run):
    """Growth of the resident memory at its peak."""
    table = Table('memory', '1242x375, 128 disparities', ['MB'])
    for label, name in run.few(MEMORY, MEMORY[:1]):
        # One process each: memory that one has freed would be used by the next.
        text = run.text('benchmark_stages', '--benchmark_filter=^%s/1' % name, '--benchmark_format=csv',
                        *run.few([], ['--benchmark_min_time=0.01']),
                        shown='benchmark_stages --benchmark_filter=^STAGE/1')
        rows = text[text.index('name,'):].splitlines()
        heads = [head.strip('"') for head in rows[0].split(',')]
        if len(rows) < 2 or 'MB' not in heads:
            raise running.ToolFailed('benchmark_stages has no memory of %s' % name)
        table.add(label, [number(rows[1].split(',')[heads.index('MB')])], 0)
    return table


@section('tool:load_test', 'tool:kitti_to_bag', _drive(9))
def latency(run):
    """Three nodelets in one process, from a left image to its moving objects."""
    bag = run.path('0009.bag')
    if os.path.exists(bag):
        os.remove(bag)
    run.text('kitti_to_bag', DAY, DRIVE % 9, bag)
    with running.roscore(run.path('logs/roscore.txt')) as environment:
        text = run.text('load_test', '--bag', bag, '--rates', '10,max', '--frames', run.few('100', '20'),
                        env=environment)
    columns = ['sent', 'lost', 'reached Hz', 'p50 ms', 'p95 ms', 'p99 ms', 'max ms', 'memory MB']
    table = Table('latency', 'asked Hz', columns)
    heads = []
    for line in text.splitlines():
        cells = line.split()
        if cells[:2] == ['asked', 'Hz']:
            heads = re.findall(r'\w+(?: Hz| ms| MB)?', line)
        elif cells and cells[0] in ('10.0', 'max') and len(cells) == len(heads):
            table.add({'max': 'as fast as nothing is lost'}.get(cells[0], cells[0]),
                      [number(cells[heads.index(column)]) for column in columns], [0, 0] + [1] * 5 + [0])
    if not table.rows:
        raise running.ToolFailed('load_test printed no figures')
    return table
