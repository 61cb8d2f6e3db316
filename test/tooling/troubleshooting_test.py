#!/usr/bin/python3
"""docs/troubleshooting.md has every message of the sources, and none that they do not have."""

import pathlib
import re
import sys
import unittest

sys.dont_write_bytecode = True
import messages  # noqa: E402

REPOSITORY = pathlib.Path(sys.argv[1])
# What looks like a message but never gets out.
INTERNAL = {
    'empty box',  # becomes "is not a label"
    "], 'enum_description': ''}", 'SIMD target', 'the calibration', 'first frame',
}


def quoted():
    """The messages of the page: lists of their fixed parts."""
    text = (REPOSITORY / 'docs/troubleshooting.md').read_text()
    # Each entry of a list begins with its messages.
    entries = re.findall(r'^- ((?:`[^`]+`(?:,\s+)?)+)', text, re.MULTILINE)
    cells = [cell for entry in entries for cell in re.findall(r'`([^`]+)`', entry)]
    # '...' is a gap; dots of a message itself are written as one character.
    return [[part.strip(" '\"():;,").replace('…', '...') for part in cell.split('...')]
            for cell in cells]


class Troubleshooting(unittest.TestCase):

    def test_every_message_is_there(self):
        parts = [part for cell in quoted() for part in cell]
        missing = ['%s: %s' % (file, text) for text, file in messages.messages(REPOSITORY).items()
                   if text not in INTERNAL and not any(text in part for part in parts)]
        self.assertEqual(missing, [], 'add them to docs/troubleshooting.md, with their cure')

    def test_every_entry_is_a_message(self):
        # Texts are joined, as the literals of one message are.
        sources = '\n'.join(messages.all_literals(REPOSITORY))
        wrong = [part for cell in quoted() for part in cell if part and part not in sources]
        self.assertEqual(wrong, [], 'no source says this any more')

    def test_the_reader_of_sources_sees_what_it_should(self):
        code = messages.without_comments(
            'fail(a + ": has " + n + " numbers, "\n "expected 30");  // not (this)\n'
            'throw UsageError("it\'s " + x);\n')
        found = [messages.telling(messages.statement(code, m.end() - 1, ')'))
                 for m in messages.CALL.finditer(code)]
        self.assertEqual(found, ['numbers, expected 30', ''])


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1], verbosity=2)
