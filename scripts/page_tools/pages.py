"""Parts of the pages of demo, report and evaluate_many, so that all have one style."""

import html
import os

STYLE = '''
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 1240px; padding: 0 1em;
       color: #222; background: #fff }
h1 { margin-bottom: 0 } h2 { margin-top: 2em }
table { border-collapse: collapse; margin: .5em 0 } caption { text-align: left; font-weight: bold }
td, th { padding: .2em .8em; border-bottom: 1px solid #ddd; text-align: right; vertical-align: bottom }
td:first-child, th:first-child { text-align: left }
figure { display: inline-block; margin: .4em } figure img { max-width: 100% }
figcaption, .note { color: #666 } pre { background: #f6f6f6; padding: .6em; overflow-x: auto }
'''


def table(header, rows, title='', classes=None):
    """classes: of the rows, for their style; None for none."""
    def line(cells, tag, kind):
        text = ''.join('<%s>%s</%s>' % (tag, html.escape(str(cell)), tag) for cell in cells)
        return '<tr%s>%s</tr>\n' % (' class="%s"' % kind if kind else '', text)
    caption = '<caption>%s</caption>' % html.escape(title) if title else ''
    return '<table>%s\n%s%s</table>\n' % (
        caption, line(header, 'th', None),
        ''.join(line(row, 'td', kind) for row, kind in zip(rows, classes or [None] * len(rows))))


def figure(file, caption):
    """A picture that is there already. file: relative to the page."""
    return '<figure><img loading="lazy" src="%s" alt="%s"><figcaption>%s</figcaption></figure>\n' % tuple(
        html.escape(text) for text in (file, caption, caption))


def page(title, body, style=''):
    """A page as text. title: plain text; body, style: HTML and CSS."""
    return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>predictive_stereo: '
            '{title}</title><style>{style}</style></head><body>\n<h1>{title}</h1>\n{body}</body></html>\n'
            ).format(title=html.escape(title), style=STYLE + style, body=body)


def write(path, text):
    """Writes all of the text or, on an error, leaves the file as it was."""
    partial = '%s.part%d' % (path, os.getpid())
    try:
        with open(partial, 'w', encoding='utf-8') as file:
            file.write(text)
        os.replace(partial, path)
    except OSError:
        if os.path.exists(partial):
            os.remove(partial)
        raise
