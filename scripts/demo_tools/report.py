"""The demo's report: one page that needs no other file."""

import base64
import html
import os
import sys
from collections import OrderedDict, namedtuple

import numpy as np
import rosbag
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from predictive_stereo.msg import MovingObjectArray

from panels import unpack

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), '../page_tools'))
import pages  # noqa: E402
import plots  # noqa: E402

Run = namedtuple('Run', 'title bag rate launch_file recording drawn')

STYLE = '''
.names td:nth-child(2), .names th:nth-child(2) { text-align: left }
#frame { width: 100%; background: #202020 } #strip { white-space: nowrap; overflow-x: auto }
#strip img { height: 74px; cursor: pointer; margin-right: 2px }
.controls { display: flex; gap: 1em; align-items: center } .controls input { flex: 1 }
'''

SCRIPT = '''
const frame = document.getElementById('frame'), slider = document.getElementById('slider');
const label = document.getElementById('label'), button = document.getElementById('play');
let timer = null;
function show(i) { slider.value = i; frame.src = pictures[i]; label.textContent = labels[i]; }
function stop() { clearInterval(timer); timer = null; button.textContent = 'Play'; }
function play() { timer = setInterval(() => show((+slider.value + 1) % pictures.length), 150);
                  button.textContent = 'Stop'; }
slider.oninput = () => { stop(); show(+slider.value); };
button.onclick = () => timer ? stop() : play();
const strip = document.getElementById('strip');
pictures.forEach((picture, i) => {
  if (i % Math.ceil(pictures.length / 20)) return;
  const small = document.createElement('img');
  small.src = picture; small.onclick = () => { stop(); show(i); }; strip.append(small);
});
show(first);
'''


def positions(odometry):
    return np.array([[m.pose.pose.position.x, m.pose.pose.position.y, m.pose.pose.position.z]
                     for m in odometry])


def length(path):
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) if len(path) > 1 else 0.0


def true_path(run):
    """Poses of truth/odometry of a synthetic bag by stamp; empty where there are none."""
    topic = run.recording.camera + '/truth/odometry'
    with rosbag.Bag(run.bag) as bag:
        return {m.header.stamp.to_nsec(): m for _, m, _ in bag.read_messages(topic)}


def path_section(run):
    odometry = [unpack(Odometry, data) for data in run.recording.small['odometry']]
    if not odometry:
        return '<p>None.</p>'
    path = positions(odometry)
    duration = (odometry[-1].header.stamp - odometry[0].header.stamp).to_sec()
    text = '<p>%.1f m in %.1f s, from above' % (length(path), duration)
    truth = true_path(run)
    both = [(m, truth[m.header.stamp.to_nsec()]) for m in odometry
            if m.header.stamp.to_nsec() in truth]
    true = positions([t for _, t in both])
    if both:
        error = np.linalg.norm(positions([m for m, _ in both]) - true, axis=1)
        text += '. Error of the position at the end: %.2f m after %.1f m (%.2f %%)' % (
            error[-1], length(true), 100 * error[-1] / max(length(true), 1e-9))
    curves = [(name, p[:, 0], p[:, 1], '-') for name, p in (('truth', true), ('odometry', path)) if len(p)]
    return text + '.</p>' + plots.svg('Path', 'ahead at the start [m]', 'to its left [m]', curves, equal_axes=True)


def objects_section(run):
    seen = OrderedDict()
    frames = 0
    for data in run.recording.small['moving_objects']:
        frames += 1
        for found in unpack(MovingObjectArray, data).objects:
            seen.setdefault(found.id, []).append(found)
    if not seen:
        return '<p>None in %d frames.</p>' % frames
    rows = []
    for number, found in seen.items():
        speeds = [np.linalg.norm([f.velocity.x, f.velocity.y, f.velocity.z]) for f in found
                  if f.velocity_covariance[0] >= 0]
        distances = [f.distance for f in found]
        rows.append([number, len(found), '%.1f ... %.1f' % (min(distances), max(distances)),
                     '%.1f' % np.median(speeds) if speeds else 'not known',
                     '%.1f x %.1f' % (np.median([f.size.x for f in found]),
                                      np.median([f.size.y for f in found])),
                     '%.2f' % np.mean([f.score for f in found])])
    return pages.table(['id', 'frames', 'distance [m]', 'median speed over ground [m/s]',
                  'median width x height [m]', 'mean score'], rows)


def accuracy_section(run):
    names = list(OrderedDict.fromkeys(n for d in run.drawn for n in d.figures))
    rows = []
    for name in names:
        # The first frame has no past: it is not what the method does.
        values = [d.figures[name] for d in run.drawn[1:] or run.drawn if name in d.figures]
        rows.append([name, '%.2f' % np.nanmean(values), '%.2f' % np.nanmin(values),
                     '%.2f' % np.nanmax(values)])
    note = ''
    if any('outliers [%]' in d.figures for d in run.drawn):
        note = '<p class="note">Outlier: more than 3 px and more than 5 % from the exact truth, all ' \
            'pixels counted, also those that the right camera does not see.</p>'
    return pages.table(['of %d drawn frames' % len(run.drawn), 'mean', 'smallest', 'largest'],
                 rows) + note


def times_section(run):
    """Means of the figures in the diagnostics, by nodelet."""
    sums = OrderedDict()
    for data in run.recording.diagnostics:
        for status in unpack(DiagnosticArray, data).status:
            for item in status.values:
                if not item.key.endswith('[ms]'):
                    continue
                try:
                    value = float(item.value)
                except ValueError:
                    continue
                sums.setdefault((status.name, item.key[:-len(' [ms]')]), []).append(value)
    rows = []
    for nodelet in OrderedDict.fromkeys(name for name, _ in sums):
        for (name, stage), values in sums.items():
            if name == nodelet:
                rows.append([nodelet.split(': ')[-1] if stage == 'latency' else '', stage,
                             '%.1f' % np.mean(values), '%.1f' % max(values)])
    return pages.table(['nodelet', 'stage', 'mean ms', 'largest mean of a second'], rows)


def first_shown(run):
    """Index of the drawn frame with the most objects."""
    count = {m.header.stamp.to_nsec(): len(m.objects) for m in
             (unpack(MovingObjectArray, data) for data in run.recording.small['moving_objects'])}
    return max(range(len(run.drawn)), key=lambda i: count.get(run.drawn[i].stamp_ns, 0))


def write(path, run):
    """Writes the report of a run."""
    pictures = ','.join('"data:image/jpeg;base64,%s"' % base64.b64encode(d.jpeg).decode()
                        for d in run.drawn)
    labels = ','.join('"%.2f s"' % (1e-9 * (d.stamp_ns - run.drawn[0].stamp_ns)) for d in run.drawn)
    speed = '' if run.rate == 1 else \
        ' The bag was played at %g times its speed; times are of this machine under this load.' % \
        run.rate
    text = '''<p class="note">{complete} frames went through the nodelets of {launch_file}.{speed}</p>
<img id="frame" alt="left image with moving objects, disparity, standard deviation, residual">
<div class="controls"><button id="play">Play</button>
<input id="slider" type="range" min="0" max="{last}" value="0"><span id="label"></span></div>
<div id="strip"></div>
<h2>Disparity</h2>{accuracy}
<h2>Moving objects</h2>{objects}
<h2>Path</h2>{path}
<h2>Time</h2>
<p class="note">From the nodelets' diagnostics. Latency: from the arrival of a nodelet's last input
to its output. The nodelets work side by side: their times do not add up.</p><div class="names">{times}</div>
<script>const pictures = [{pictures}], labels = [{labels}], first = {first};{script}</script>
'''.format(complete=run.recording.complete,
           launch_file=html.escape(run.launch_file), speed=speed, last=len(run.drawn) - 1,
           accuracy=accuracy_section(run), objects=objects_section(run), path=path_section(run),
           times=times_section(run), first=first_shown(run), pictures=pictures, labels=labels, script=SCRIPT)
    pages.write(path, pages.page(run.title, text, STYLE))
