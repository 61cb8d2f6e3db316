#!/bin/bash
# Every C++ file is formatted as .clang-format says.
set -euo pipefail
cd "$(dirname "$0")/../.."
find examples include src test -name '*.h' -o -name '*.cpp' | xargs clang-format --dry-run -Werror
