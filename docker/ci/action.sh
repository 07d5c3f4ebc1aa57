#!/usr/bin/env bash
# The step `check` of action.yml: takes the released program, runs `meshgauge check` at the root of the repository, and gives GitHub
# the summary of the job, annotations, the outputs and the exit code. The variables are those that action.yml sets.
set -euo pipefail

reports=${INPUT_REPORTS:-meshgauge-reports}
log=$reports/log.txt
summary=$reports/summary.md
comment=$reports/comment.md
sarif=$reports/meshgauge.sarif
annotations=$reports/annotations.txt
base=$reports/base
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The version of a release: the one that was asked for, else that of this copy of the action.
version_to_run() {
  if [[ -n ${INPUT_VERSION:-} ]]; then echo "$INPUT_VERSION"; return; fi
  sed -nE 's/^project\(meshgauge VERSION ([^ ]+).*/\1/p' "$(dirname "${BASH_SOURCE[0]}")/../../CMakeLists.txt"
}

download() {
  if command -v curl >/dev/null; then
    curl --fail --silent --show-error --location --retry 3 --max-time 300 --output "$work/$1" "$2/$1"
  else
    wget -q -T 300 -O "$work/$1" "$2/$1" || { echo "$2/$1: wget failed, and there is no curl"; return 1; }
  fi
}

# The runners that a release has programs for, by its list: "linux-x86_64".
runners_in() { sed -nE 's/^[0-9a-f]{64}  meshgauge-[0-9.]+-([a-z]+-[A-Za-z0-9_]+)\.tar\.gz$/\1/p' "$1" | paste -sd ' ' -; }

# Downloads the release and unpacks it to $work/image. Its digest must be the one that was given, else the one that the release's own
# list says.
fetch_program() {
  local version machine name releases sums
  version=$(version_to_run)
  machine=$(uname -s | tr '[:upper:]' '[:lower:]')-$(uname -m)
  name=meshgauge-$version-$machine
  releases=${INPUT_RELEASES:-${GITHUB_SERVER_URL:-https://github.com}/${ACTION_REPOSITORY:-${GITHUB_REPOSITORY:-}}/releases/download}
  echo "meshgauge $version of $releases"
  if [[ -n ${INPUT_SHA256:-} ]]; then
    sums="$INPUT_SHA256  $name.tar.gz"
  else
    download SHA256SUMS "$releases/v$version" || return
    sums=$(grep -F "  $name.tar.gz" "$work/SHA256SUMS") || {
      echo "SHA256SUMS of the release does not list $name.tar.gz: there is no program for this runner, $machine."
      echo "There are programs for: $(runners_in "$work/SHA256SUMS"). Run the job on such a runner, as by 'runs-on: ubuntu-latest'."
      return 1
    }
  fi
  download "$name.tar.gz" "$releases/v$version" || return
  (cd "$work" && sha256sum --check --quiet <<<"$sums") || { echo "$name.tar.gz is not the file with this SHA-256: ${sums%% *}"; return 1; }
  mkdir "$work/image" || return
  tar -xzf "$work/$name.tar.gz" -C "$work/image" --strip-components=1
}

# The program needs nothing of a system, so it runs as it is. A container for it is asked for: in a job that is a container itself,
# docker knows other folders than this one.
run_program() {
  if [[ ${INPUT_CONTAINER:-false} == true ]]; then run_container "$@"; else "$work/image/meshgauge" "$@"; fi
}

# Without rights and, unless a service measures, without a network: the meshes may come from a stranger's pull request. The
# program is an image by itself.
run_container() {
  local code=0 image confined=(--read-only --tmpfs /tmp --cap-drop ALL --security-opt no-new-privileges)
  docker info >/dev/null 2>&1 || { echo "The input 'container' needs docker, which does not run here: leave it out."; return 3; }
  # The certificates that this runner trusts, for a service by https.
  mkdir -p "$work/image/etc/ssl/certs"
  cp /etc/ssl/certs/ca-certificates.crt "$work/image/etc/ssl/certs/" 2>/dev/null || true
  image=$(tar -C "$work/image" -c . | docker import - meshgauge:action) || return 3
  [[ -n ${INPUT_SERVER:-} ]] || confined+=(--network none)
  docker run --rm --user "$(id -u):$(id -g)" "${confined[@]}" --env MESHGAUGE_KEY \
    --mount "type=bind,source=$PWD,target=$PWD" --workdir "$PWD" --entrypoint /meshgauge "$image" "$@" || code=$?
  if ((code == 125)); then
    echo "docker could not start the container; in a job that is a container itself, it has no folder $PWD: leave out the input 'container'."
    return 3
  fi
  return "$code"
}

flags=(--junit "$reports/junit.xml" --sarif "$sarif" --markdown "$summary" --comment "$comment" --html "$reports/report.html"
  --pictures "$reports/pictures" "--json=$reports/report.json" "--annotations=$annotations")
[[ -z ${INPUT_UNDECIDED:-} ]] || flags+=(--undecided "$INPUT_UNDECIDED")
[[ -z ${INPUT_SERVER:-} ]] || flags+=(--server "$INPUT_SERVER")
# The base's report, if the step before has found one; it is named by its commit, the end of the key.
key=${ACTION_BASE:-}
since=$base/${key##*-}.json
if [[ -n $key && -s $since && ${INPUT_ARGUMENTS:-} != *--since* ]]; then flags+=(--since "$since"); fi
while IFS= read -r argument; do
  [[ -z $argument ]] || flags+=("$argument")
done <<<"${INPUT_ARGUMENTS:-}"

mkdir -p "$reports"
# Files of an earlier step.
rm -rf "$summary" "$comment" "$sarif" "$log" "$annotations" "$reports"/{junit.xml,report.html,report.json,pictures}
# Names of files and gates are a stranger's: until the word at the end, GitHub takes no line of the log for a command.
word=$(od -An -N16 -tx1 /dev/urandom | tr -d ' \n')
echo "::stop-commands::$word"
code=0
# `if` takes `set -e` from what is within: fetch_program says itself where it fails.
if fetch_program >"$log" 2>&1; then
  run_program check "${INPUT_MANIFEST:-gates.yaml}" "${flags[@]}" 2>&1 | tee "$log" || code=$?
else
  code=3
  echo "The program could not be fetched; its release is set by the inputs version, sha256 and releases." >>"$log"
  cat "$log"
fi
echo "::$word::"
if [[ -s $annotations ]]; then cat "$annotations"; fi

case $code in
  0) verdict=pass ;;
  1) verdict=fail ;;
  2) verdict=undecided ;;
  *) verdict=error ;;
esac

# Without a summary nothing was measured: the log says why, in a block that none of its lines can end.
nothing_measured() {
  printf '## ❌ meshgauge: nothing was measured\n\n'
  head -c 20000 "$log" | sed 's/^/    /'
}
[[ -s $summary ]] || nothing_measured >"$summary"
[[ -s $comment ]] || nothing_measured >"$comment"
cat "$summary" >>"$GITHUB_STEP_SUMMARY"

# What pull requests are compared with later.
kept=''
if [[ ${GITHUB_EVENT_NAME:-} == push && $verdict != error && -s $reports/report.json ]]; then
  rm -rf "$base"
  mkdir "$base"
  kept=$base/$GITHUB_SHA.json
  cp "$reports/report.json" "$kept"
fi

{
  echo "verdict=$verdict"
  echo "exit-code=$code"
  echo "reports=$reports"
  if [[ -n $kept ]]; then echo "kept=$kept"; fi
  if [[ -s $sarif ]]; then echo "sarif=$sarif"; fi
} >>"$GITHUB_OUTPUT"
exit "$code"
