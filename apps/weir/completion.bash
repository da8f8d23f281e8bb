# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash
# Completes commands and options of `weir` in bash; file names where no command or option fits.
_weir() {
  local words
  mapfile -t words < <("${COMP_WORDS[0]}" complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
  COMPREPLY=("${words[@]}")
}
complete -o default -o bashdefault -F _weir weir
