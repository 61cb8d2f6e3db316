#!/usr/bin/python3
"""One job: measure.py RECORDING MEASUREMENT THREADS, in the output folder of evaluate_many.

Snakemake's shell sees only these three words: no text of the list reaches a shell.
"""
import json
import os
import subprocess
import sys

sys.dont_write_bytecode = True
import recordings  # noqa: E402


def settings():
    with open('run.json', encoding='utf-8') as file:
        return json.load(file)


def command(run, recording, measurement, threads):
    """The program and its arguments."""
    folder = os.path.join('recordings', recording.name)
    arguments = run['arguments'] + (['--config', run['config']] if run['config'] else [])
    return recording.command(measurement, run['tools'], os.path.join(folder, measurement + '.csv'),
                             threads, arguments, os.path.join(folder, 'replay.bag'))


def main():
    name, measurement, threads = sys.argv[1:]
    run = settings()
    recording = recordings.read_list(run['list'], run['labels'])[name]
    words = command(run, recording, measurement, int(threads))
    with open(os.path.join('logs', name, measurement + '.log'), 'wb') as log:
        log.write((' '.join(words) + '\n').encode())
        log.flush()
        status = subprocess.run(words, stdout=log, stderr=subprocess.STDOUT,
                                stdin=subprocess.DEVNULL).returncode
        log.write(('exit status %d\n' % status).encode())
    return 1 if status else 0


if __name__ == '__main__':
    sys.exit(main())
