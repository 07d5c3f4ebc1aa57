#!/usr/bin/env bash
# The step `comment` of action.yml. It always succeeds: without a comment, the summary of the job says why.
set -uo pipefail

script=$(dirname "${BASH_SOURCE[0]}")/comment.py

# For the case that its own limit does not end it.
limited() { if command -v timeout >/dev/null; then timeout -k 5 120 "$@"; else "$@"; fi; }

if ! command -v python3 >/dev/null; then
  why='this runner has no python3'
# What Python says of a failure by itself might show the token. -I: it takes no module of the repository.
elif said=$(limited python3 -I "$script" 2>/dev/null); then
  printf 'meshgauge: %s\n' "$said"
  exit 0
else
  why=${said:-it could not be written}
fi
printf 'meshgauge: no comment on the pull request: %s\n' "$why"
printf '\nThere is no comment on the pull request: %s.\n' "$why" >>"$GITHUB_STEP_SUMMARY"
