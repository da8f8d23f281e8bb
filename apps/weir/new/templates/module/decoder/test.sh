#!/bin/sh
# Runs the decoder on two frames: sh test.sh FILE
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
WEIR_MODULE_PATH=$(dirname "$1")
export WEIR_MODULE_PATH
printf '\000\001\002\003\310\310\310\310' > "$folder/in"
printf '1\n200\n' > "$folder/expected"
"${WEIR_COMMAND:-weir}" run "filesrc location=$folder/in blocksize=4 ! application/octet-stream !
  tensor_converter input-dim=4 input-type=uint8 ! tensor_decoder mode=my-decoder !
  filesink location=$folder/out" > "$folder/output" 2>&1 || { cat "$folder/output" && exit 1; }
cmp "$folder/expected" "$folder/out"
echo "my-decoder works"
