#!/bin/sh
# Runs the engine on one frame, in the pipeline's process and in a worker process: sh test.sh FILE
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
WEIR_MODULE_PATH=$(dirname "$1")
export WEIR_MODULE_PATH
echo 3 > "$folder/three.model"
printf '\000\001\177\377' > "$folder/in"
printf '\006\007\205\005' > "$folder/expected"
for place in none process; do
  rm -f "$folder/out"
  "${WEIR_COMMAND:-weir}" run "filesrc location=$folder/in blocksize=4 ! application/octet-stream !
    tensor_converter input-dim=4 input-type=uint8 !
    tensor_filter framework=my-engine model=$folder/three.model custom=times:2 isolate=$place !
    filesink location=$folder/out" > "$folder/output" 2>&1 || { cat "$folder/output" && exit 1; }
  cmp "$folder/expected" "$folder/out"
done
echo "my-engine works"
