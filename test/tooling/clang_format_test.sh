#!/bin/bash
# Every C++ file is formatted as .clang-format says.
set -euo pipefail
cd "$(dirname "$0")/../.."
find include src test -name '*.h' -o -name '*.cpp' | xargs clang-format --dry-run -Werror
