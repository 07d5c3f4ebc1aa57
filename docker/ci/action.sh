#!/usr/bin/env bash
# The step of action.yml: runs `meshgauge check` in its container, at the root of the repository, and gives GitHub the
# summary of the job, the outputs and the exit code. The variables are those that action.yml sets.
set -euo pipefail

reports=${INPUT_REPORTS:-meshgauge-reports}
log=$reports/log.txt
summary=$reports/summary.md
sarif=$reports/meshgauge.sarif

# Fails when there is none: `if` and `||` around a function take `set -e` from it.
# The image that was asked for, else the one published with this version of the action, else built from its source.
image_to_run() {
  local published here
  if [[ -n ${INPUT_IMAGE:-} ]]; then echo "$INPUT_IMAGE"; return; fi
  published=ghcr.io/$(tr '[:upper:]' '[:lower:]' <<<"${ACTION_REPOSITORY:-}"):${ACTION_REF:-}
  if [[ -n ${ACTION_REPOSITORY:-} && -n ${ACTION_REF:-} ]] && docker pull --quiet "$published" >&2; then
    echo "$published"
    return
  fi
  echo "No image is published as $published: building it, which takes minutes. The input 'image' spares that." >&2
  here=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
  docker build --quiet --file "$here/docker/Dockerfile" --tag meshgauge:action "$here" >&2 || return
  echo meshgauge:action
}

# Without rights and, unless a service measures, without a network: the meshes may come from a stranger's pull request.
in_container() {
  local confined=(--read-only --tmpfs /tmp --cap-drop ALL --security-opt no-new-privileges)
  [[ -n ${INPUT_SERVER:-} ]] || confined+=(--network none)
  docker run --rm --user "$(id -u):$(id -g)" "${confined[@]}" --env MESHGAUGE_KEY \
    --mount "type=bind,source=$PWD,target=$PWD" --workdir "$PWD" --entrypoint meshgauge "$@"
}

flags=(--junit "$reports/junit.xml" --sarif "$sarif" --markdown "$summary" --html "$reports/report.html"
  "--json=$reports/report.json")
[[ -z ${INPUT_UNDECIDED:-} ]] || flags+=(--undecided "$INPUT_UNDECIDED")
[[ -z ${INPUT_SERVER:-} ]] || flags+=(--server "$INPUT_SERVER")
while IFS= read -r argument; do
  [[ -z $argument ]] || flags+=("$argument")
done <<<"${INPUT_ARGUMENTS:-}"

mkdir -p "$reports"
rm -f "$summary" "$sarif" "$log" "$reports"/{junit.xml,report.html,report.json}  # files of an earlier step
code=0
if image=$(image_to_run); then
  in_container "$image" check "${INPUT_MANIFEST:-gates.yaml}" "${flags[@]}" 2>&1 | tee "$log" || code=$?
else
  code=3
  echo "There is no image to run: neither could one be pulled nor built." | tee "$log"
fi

case $code in
  0) verdict=pass ;;
  1) verdict=fail ;;
  2) verdict=undecided ;;
  *) verdict=error ;;
esac

# Without a summary nothing was measured: the log says why, in a block that none of its lines can end.
if [[ -s $summary ]]; then
  cat "$summary"
else
  printf '## ❌ meshgauge: nothing was measured\n\n'
  sed 's/^/    /' "$log"
fi >>"$GITHUB_STEP_SUMMARY"

{
  echo "verdict=$verdict"
  echo "exit-code=$code"
  echo "reports=$reports"
  if [[ -s $sarif ]]; then echo "sarif=$sarif"; fi
} >>"$GITHUB_OUTPUT"
exit "$code"
