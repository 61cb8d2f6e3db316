"""Messages that wrong input can give, as the sources have them."""

import pathlib
import re

# What ends in front of a user: exceptions, findings of check_bag, problems and logs of nodelets.
CALL = re.compile(r'\b(?:invalid_argument|runtime_error|logic_error|UsageError|refuse|fail|fault|'
                  r'advice|problem|InvalidArgumentException|ROS_(?:WARN|ERROR)_STREAM)\s*\(')
# Texts that such a call gets from elsewhere.
TEXT = re.compile(r'\b(?:text <<|text = |text \+= |return text \+ |reason = |return |snprintf\()')
LITERAL = re.compile(r'"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*')


def skip_quoted(code, start):
    """The place behind a string or character that begins at `start`."""
    if code.startswith('R"(', start):
        return code.index(')"', start) + 2
    quote, end = code[start], start + 1
    while code[end] != quote:
        end += 2 if code[end] == '\\' else 1
    return end + 1


def is_quote(code, at):
    return code[at] == '"' or code.startswith('R"(', at) or \
        code[at] == "'" and not code[at - 1].isalnum()


def without_comments(code):
    parts, at = [], 0
    while at < len(code):
        if is_quote(code, at):
            end = skip_quoted(code, at)
            # Help texts are no messages.
            parts.append('""' if code[at] == 'R' else code[at:end])
        elif code.startswith('//', at):
            end = code.find('\n', at)
            end = len(code) if end < 0 else end
        else:
            end = at + 1
            parts.append(code[at])
        at = end
    return ''.join(parts)


def statement(code, start, ends):
    """From `start` to the first of `ends` that is in no parentheses and no string."""
    depth, at = 0, start
    while at < len(code):
        if is_quote(code, at):
            at = skip_quoted(code, at)
            continue
        depth += (code[at] in '({') - (code[at] in ')}')
        if depth < 0 or depth == 0 and code[at] in ends:
            break
        at += 1
    return code[start:at + 1]


def telling(code):
    """The longest of the joined string literals; empty where none has two words."""
    texts = [''.join(part.encode().decode('unicode_escape') for part in
                     re.findall(r'"((?:[^"\\\n]|\\.)*)"', literal)) for literal in LITERAL.findall(code)]
    # A number's format cuts a text as a value does.
    parts = [part.strip(" \n'\"():;,") for text in texts
             for part in re.split(r'%[0-9.]*[a-z]+|\n', text)]
    longest = max(parts, key=len, default='')
    return longest if ' ' in longest else ''


def messages(root):
    """{telling part: file} of all sources."""
    found = {}
    for folder in 'src', 'include':
        for path in sorted((pathlib.Path(root) / folder).rglob('*.[ch]*')):
            code = without_comments(path.read_text())
            name = str(path.relative_to(root))
            parts = [statement(code, match.end() - 1, ')') for match in CALL.finditer(code)]
            if re.search('nodelets/|bag_check|stereo_topics|replay.cpp|matching/|sequence_guard', name):
                parts += [statement(code, match.start(), ';') for match in TEXT.finditer(code)]
            for part in parts:
                text = telling(part)
                if text:
                    found.setdefault(text, name)
    return found


def all_literals(root):
    """All strings of the sources, to look for quoted parts in."""
    texts = []
    for folder in 'src', 'include':
        for path in sorted((pathlib.Path(root) / folder).rglob('*.[ch]*')):
            code = without_comments(path.read_text())
            texts += [''.join(part.encode().decode('unicode_escape') for part in
                              re.findall(r'"((?:[^"\\\n]|\\.)*)"', literal))
                      for literal in LITERAL.findall(code)]
    return texts
