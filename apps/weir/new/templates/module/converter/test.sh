#!/bin/sh
# Runs the converter on two frames: sh test.sh FILE
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
WEIR_MODULE_PATH=$(dirname "$1")
export WEIR_MODULE_PATH
printf '1 -2\n3 04\n' > "$folder/in"
printf '\001\000\000\000\376\377\377\377\003\000\000\000\004\000\000\000' > "$folder/expected"
"${WEIR_COMMAND:-weir}" run "filesrc location=$folder/in blocksize=5 !
  application/x-my-converter,framerate=30/1 ! tensor_converter !
  filesink location=$folder/out" > "$folder/output" 2>&1 || { cat "$folder/output" && exit 1; }
cmp "$folder/expected" "$folder/out"
echo "my-converter works"
