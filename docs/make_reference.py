#!/usr/bin/env python3
"""make_reference.py OUT.html HEADER...: the public headers as one page, their comments as prose, every name a link.

The comment above a declaration, or above a run of declarations without an empty line between them, is what is said about it. A
function or a type that nothing is said about is an error: exit status 1, one line each on standard error."""
import html
import re
import sys
from pathlib import Path

NAME = re.compile(r"\b(?:scree_\w+|SCREE_\w+)\b")
OPAQUE = re.compile(r"^typedef (?:struct|enum|union) \w+ (\w+);", re.M)  # what these are, the head of the file says
DEFINES = (
    re.compile(r"^SCREE_API\b[^;(]*?\b(scree_\w+)\(", re.M),  # functions
    OPAQUE,
    re.compile(r"^typedef (?:struct|enum|union) (\w+) \{", re.M),
    re.compile(r"^typedef [^;{]*\(\*(\w+)\)\(", re.M),
    re.compile(r"^#define (SCREE_\w+)", re.M),
    re.compile(r"^  (SCREE_\w+)(?: =|,|$)", re.M),  # enumerators
)
STYLE = """body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
pre { background: #f4f3f0; padding: .6rem .8rem; overflow-x: auto; font-size: 13px; line-height: 1.45; }
a { color: #2a5a8a; text-decoration: none; } a:hover { text-decoration: underline; }
nav { columns: 3; font-size: 13px; } h2 { margin-top: 3rem; border-bottom: 1px solid #ccc; } .note { color: #777; }
@media (prefers-color-scheme: dark) { body { background: #1c1c1c; color: #ddd; } pre { background: #282826; } a { color: #8bb8e8; } }"""


def comment_text(raw):
    """The words of a comment, line by line, without its marks."""
    lines = raw.strip()[2:-2].split("\n")
    return "\n".join(re.sub(r"^ ?\*? ?", "", line) if i else line.strip() for i, line in enumerate(lines)).strip("\n")


def groups_of(text):
    """(comments, code) of each run of lines between empty ones, at the top level of the header."""
    text = re.sub(r"\A\s*/\*.*?\*/\n", "", text, count=1, flags=re.S)
    text = re.sub(r"#ifdef __cplusplus\n.*?#endif\n", "", text, flags=re.S)
    body = re.search(r"#define SCREE_\w+_H\n(.*)#endif", text, re.S).group(1)
    body = re.sub(r"#include [^\n]*\n", "", body)
    depth, lines = 0, []
    for line in body.split("\n"):
        bare = re.sub(r"/\*.*?\*/", "", line)
        if not line.strip() and depth == 0:
            if lines:
                yield split_group("\n".join(lines))
            lines = []
            continue
        lines.append(line)
        depth += bare.count("{") - bare.count("}") + bare.count("/*") - bare.count("*/")
    if lines:
        yield split_group("\n".join(lines))


def split_group(text):
    comments = []
    while True:
        match = re.match(r"\s*(/\*.*?\*/)\s*(?=\n|$)", text, re.S)
        if not match:
            return comments, text.strip("\n")
        comments.append(comment_text(match.group(1)))
        text = text[match.end():]


def linked(text, known):
    def link(match):
        name = match.group(0)
        return f'<a href="#{name}">{name}</a>' if name in known else name
    return NAME.sub(link, html.escape(text, quote=False))


def prose(text, known):
    out = []
    for paragraph in re.split(r"\n\s*\n", text):
        lines = paragraph.split("\n")
        if all(line.startswith("  ") for line in lines):  # a drawing or a table
            out.append(f"<pre>{linked(paragraph, known)}</pre>")
        else:
            items = re.split(r"\n(?=- )", paragraph)
            out.extend(f"<p>{linked(item, known)}</p>" for item in items)
    return "\n".join(out)


def main(out, paths):
    headers, known, silent = [], {}, []
    for path in sorted(paths, key=lambda p: (p.stem != "base", p.stem)):
        text = path.read_text(encoding="utf-8")
        head = re.match(r"\s*(/\*.*?\*/)", text, re.S)
        if not head:
            silent.append(f"{path.name}: nothing says what the header is for")
        groups = list(groups_of(text))
        headers.append((path.stem, comment_text(head.group(1)) if head else "", groups))
        for comments, code in groups:
            for pattern in DEFINES:
                for match in pattern.finditer(code):
                    known.setdefault(match.group(1), path.stem)
                    if not comments and "/*" not in code and not match.group(1).startswith("SCREE_") and pattern != OPAQUE:
                        silent.append(f"{path.name}: nothing is said about {match.group(1)}")
    anchored = set()

    def code_block(code):
        shown = linked(code, known)
        for pattern in DEFINES:
            for match in pattern.finditer(code):
                name = match.group(1)
                if name not in anchored:
                    anchored.add(name)
                    shown = shown.replace(f'<a href="#{name}">{name}</a>', f'<b id="{name}">{name}</b>', 1)
        return f"<pre>{shown}</pre>"

    parts = []
    for stem, head, groups in headers:
        parts.append(f'<h2 id="{stem}.h">scree/{stem}.h</h2>\n{prose(head, known)}')
        for comments, code in groups:
            parts.extend(prose(comment, known) for comment in comments)
            if code:
                parts.append(code_block(code))
    index = " ".join(f'<a href="#{name}">{name}</a><br>' for name in sorted(known) if name.startswith("scree_"))
    contents = " ".join(f'<a href="#{stem}.h">{stem}.h</a>' for stem, _, _ in headers)
    Path(out).write_text(
        f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>scree: reference</title>\n<style>{STYLE}</style>\n<h1>scree: the public headers</h1>\n<p>{contents}</p>\n"
        f"<nav>{index}</nav>\n" + "\n".join(parts) + "\n</html>\n", encoding="utf-8")
    for line in silent:
        print(line, file=sys.stderr)
    return 1 if silent else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], [Path(p) for p in sys.argv[2:]]))
