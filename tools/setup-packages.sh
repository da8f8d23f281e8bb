# SPDX-License-Identifier: LGPL-2.1-or-later
# The Debian packages of tools/setup, which sources this file: which are missing, and installing them.
# shellcheck shell=bash

# is_installed NAME: not for another architecture.
is_installed() {
  [[ " $(dpkg-query -W -f='${db:Status-Status} ${Architecture} ' "$1" 2> /dev/null)" == *" installed "@(all|"$own_arch")" "* ]]
}

# is_offered NAME [VERSION]: whether the machine's sources have the package, in this version or a later one.
is_offered() {
  local offered
  offered=$(apt-cache show --no-all-versions "$1" 2> /dev/null | sed -n 's/^Version: //p') || return
  [[ -z ${2:-} ]] || dpkg --compare-versions "$offered" ge "$2"
}

# packages_find_missing GROUP...: sets missing_packages from packages.txt. A package marked `?` counts
# as missing only where the machine's sources offer it, in the version after `?>=` or a later one.
packages_find_missing() {
  local line group='' name version wanted=" $* "
  while read -r line; do
    line=${line%%#*}
    line=${line//\{deb-arch\}/$arch}
    read -r name _ <<< "$line"
    case $name in
      '') continue ;;
      \[*) group=${name//[\[\]]/} && continue ;;
    esac
    [[ $wanted == *" $group "* ]] || continue
    is_installed "${name%\?*}" && continue
    if [[ $name == *\?* ]]; then
      version=${name#*\?} name=${name%\?*}
      is_offered "$name" "${version#>=}" || continue
    fi
    missing_packages+=("$name")
  done < "$here/packages.txt"
}

as_root() {
  if ((EUID == 0)); then
    "$@"
  else
    sudo "$@"
  fi
}

apt_get() {
  as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@"
}

packages_install() {
  if ((EUID != 0)) && ! command -v sudo > /dev/null; then
    fail 'installing packages takes root, and there is no sudo here; as root run:' \
      "apt-get update && apt-get install --no-install-recommends $*"
  fi
  # What an interrupted call left half installed is finished first.
  if [[ -n $(dpkg --audit) ]]; then
    as_root env DEBIAN_FRONTEND=noninteractive dpkg --configure -a ||
      fail 'dpkg was interrupted earlier and cannot continue; its message is above'
  fi
  local network='Is there a network? Do the addresses in /etc/apt/sources.list* answer? Then call tools/setup again.'
  say 'apt-get update'
  apt_get update --error-on=any > "$log" 2>&1 || {
    tail -n 6 "$log" >&2
    # Old lists may still do: a source of the user's own that fails is no reason to stop.
    say 'the package lists could not all be brought up to date; going on with those that are there'
  }
  say "apt-get install $*"
  apt_get install --no-install-recommends --yes "$@" > "$log" 2>&1 || {
    tail -n 6 "$log" >&2
    fail 'the packages could not be installed; the last message of apt is above' "$network"
  }
}
