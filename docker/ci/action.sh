#!/usr/bin/env bash
# The step of action.yml: takes the released program, runs `meshgauge check` at the root of the repository, and gives GitHub the
# summary of the job, the outputs and the exit code. The variables are those that action.yml sets.
set -euo pipefail

reports=${INPUT_REPORTS:-meshgauge-reports}
log=$reports/log.txt
summary=$reports/summary.md
sarif=$reports/meshgauge.sarif
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The version of a release: the one that was asked for, else that of this copy of the action.
version_to_run() {
  if [[ -n ${INPUT_VERSION:-} ]]; then echo "$INPUT_VERSION"; return; fi
  sed -nE 's/^project\(meshgauge VERSION (\S+).*/\1/p' "$(dirname "${BASH_SOURCE[0]}")/../../CMakeLists.txt"
}

download() { curl --fail --silent --show-error --location --retry 3 --max-time 300 --output "$work/$1" "$2/$1"; }

# Downloads the release and unpacks it to $work/image. Its digest must be the one that was given, else the one that the release's own
# list says.
fetch_program() {
  local version name releases sums
  version=$(version_to_run)
  name=meshgauge-$version-linux-$(uname -m)
  releases=${INPUT_RELEASES:-${GITHUB_SERVER_URL:-https://github.com}/${ACTION_REPOSITORY:-${GITHUB_REPOSITORY:-}}/releases/download}
  echo "meshgauge $version of $releases"
  download "$name.tar.gz" "$releases/v$version" || return
  if [[ -n ${INPUT_SHA256:-} ]]; then
    sums="$INPUT_SHA256  $name.tar.gz"
  else
    download SHA256SUMS "$releases/v$version" || return
    sums=$(grep -F "  $name.tar.gz" "$work/SHA256SUMS") || { echo "SHA256SUMS of the release does not list $name.tar.gz"; return 1; }
  fi
  (cd "$work" && sha256sum --check --quiet <<<"$sums") || { echo "$name.tar.gz is not the file with this SHA-256: ${sums%% *}"; return 1; }
  mkdir "$work/image" || return
  tar -xzf "$work/$name.tar.gz" -C "$work/image" --strip-components=1
}

# Without rights and, unless a service measures, without a network: the meshes may come from a stranger's pull request. The
# program needs nothing of a system, so it is an image by itself. Where there is no docker, it runs as it is.
run_program() {
  local image confined=(--read-only --tmpfs /tmp --cap-drop ALL --security-opt no-new-privileges)
  if ! docker info >/dev/null 2>&1; then
    "$work/image/meshgauge" "$@"
    return
  fi
  # The certificates that this runner trusts, for a service by https.
  mkdir -p "$work/image/etc/ssl/certs"
  cp /etc/ssl/certs/ca-certificates.crt "$work/image/etc/ssl/certs/" 2>/dev/null || true
  image=$(tar -C "$work/image" -c . | docker import - meshgauge:action) || return 3
  [[ -n ${INPUT_SERVER:-} ]] || confined+=(--network none)
  docker run --rm --user "$(id -u):$(id -g)" "${confined[@]}" --env MESHGAUGE_KEY \
    --mount "type=bind,source=$PWD,target=$PWD" --workdir "$PWD" --entrypoint /meshgauge "$image" "$@"
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
# `if` takes `set -e` from what is within: fetch_program says itself where it fails.
if fetch_program >"$log" 2>&1; then
  run_program check "${INPUT_MANIFEST:-gates.yaml}" "${flags[@]}" 2>&1 | tee "$log" || code=$?
else
  code=3
  echo "The program could not be fetched; its release is set by the inputs version, sha256 and releases." >>"$log"
  cat "$log"
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
