#!/usr/bin/env bash
# The step `pictures` of action.yml: puts the pictures of a pull request's run on a branch that has nothing else, and gives the comment
# their address. It always succeeds: without pictures the comment has its words. The branch is one commit without a past, of the last
# run of each job and manifest of the last pull requests.
set -uo pipefail

branch=${PICTURES_BRANCH:-}
reports=${PICTURES_REPORTS:-meshgauge-reports}
url=$GITHUB_SERVER_URL/$GITHUB_REPOSITORY
subject='Pictures of meshgauge'
most_pictures=10  # as in comment.py
most_pulls=30

leave() { printf 'meshgauge: no pictures in the comment: %s\n' "$1"; exit 0; }
# What git says might show the token.
limited() { timeout -k 5 120 "$@" 2>/dev/null; }

# The names that the comment has places for, as far as there are files: check/picture_name.h says what they consist of.
names_of_pictures() {
  local name
  sed -nE 's/^<!-- picture: ([a-z0-9_.~-]+) -->$/\1/p' "$reports/comment.md" | while read -r name; do
    [[ ! -f $reports/pictures/$name ]] || echo "$name"
  done | head -n "$most_pictures"
}

is_branch() { [[ $1 =~ ^[A-Za-z0-9][A-Za-z0-9._/-]*$ ]] && git check-ref-format "refs/heads/$1"; }

[[ $reports == /* ]] || reports=$PWD/$reports
command -v git >/dev/null || leave 'this runner has no git'
is_branch "$branch" || leave 'the input pictures-branch is no name of a branch'
mapfile -t names < <(names_of_pictures)
((${#names[@]} > 0)) || leave 'there are none'
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 0
unset GIT_TRACE GIT_TRACE_CURL GIT_TRACE_PACKET GIT_CURL_VERBOSE GIT_DIR GIT_WORK_TREE
export GIT_TERMINAL_PROMPT=0 GIT_AUTHOR_NAME=meshgauge GIT_AUTHOR_EMAIL=meshgauge@users.noreply.github.com
export GIT_COMMITTER_NAME=$GIT_AUTHOR_NAME GIT_COMMITTER_EMAIL=$GIT_AUTHOR_EMAIL
# The token is in no argument, which other processes could read.
export GIT_CONFIG_COUNT=1 GIT_CONFIG_KEY_0="http.$GITHUB_SERVER_URL/.extraheader"
GIT_CONFIG_VALUE_0="Authorization: Basic $(printf 'x-access-token:%s' "${PICTURES_TOKEN:-}" | base64 | tr -d '\n')"
export GIT_CONFIG_VALUE_0
git init -q . || leave 'git does not start'

hashes=()
for name in "${names[@]}"; do
  hashes+=("$(git hash-object -w -- "$reports/pictures/$name")") || leave 'git does not take them'
done

folder=$PICTURES_PULL-$(printf '%s\n' "${PICTURES_MANIFEST:-}" "${GITHUB_JOB:-}" | cksum | cut -d ' ' -f 1)
place=$folder/$GITHUB_RUN_ID-${GITHUB_RUN_ATTEMPT:-1}

# Makes a commit of what the branch has and of this run's pictures, and pushes it unless the branch has changed meanwhile.
# False: it has, or git failed.
put() {
  local old='' commit pull i
  old=$(limited git ls-remote "$url" "refs/heads/$branch") || return
  rm -f .git/index
  if [[ -n $old ]]; then
    limited git fetch -q --depth 1 "$url" "refs/heads/$branch" || return
    old=$(git rev-parse FETCH_HEAD) || return
    # Another branch is never written over.
    [[ $(git log -1 --format=%s "$old") == "$subject" ]] || leave "the branch '$branch' has something else"
    git read-tree "$old" || return
  fi
  # Other pictures of this manifest, and those of the oldest pull requests.
  git ls-files | cut -d - -f 1 | sort -nu | grep -vxF "$PICTURES_PULL" | head -n "-$((most_pulls - 1))" >stale
  git rm -rq --cached --ignore-unmatch -- "$folder" || return
  while read -r pull; do git rm -rq --cached --ignore-unmatch -- "$pull-*" || return; done <stale
  for i in "${!names[@]}"; do
    git update-index --add --cacheinfo "100644,${hashes[i]},$place/${names[i]}" || return
  done
  commit=$(git commit-tree -m "$subject" "$(git write-tree)") || return
  limited git push -q --force-with-lease="refs/heads/$branch:$old" "$url" "$commit:refs/heads/$branch"
}

for _ in 1 2 3; do
  if put; then
    echo "address=$url/raw/$branch/$place" >>"$GITHUB_OUTPUT"
    echo "meshgauge: ${#names[@]} pictures on the branch $branch"
    exit 0
  fi
done
leave "the branch '$branch' could not be written: the job needs the permission 'contents: write'"
