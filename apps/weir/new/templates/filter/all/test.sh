#!/bin/sh
# Runs the filter on one frame, in the pipeline's process and in a worker process: sh test.sh FILE
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
printf '\000\001\177\377' > "$folder/in"
printf '\377\376\200\000' > "$folder/expected"
# The first bytes of a file, as printf reads them.
bytes() {
  head -c 64 "$folder/$1" | od -An -v -to1 | tr -d '\n' | sed 's/ /\\/g'
}
for place in none process; do
  rm -f "$folder/out"
  "${WEIR_COMMAND:-weir}" run "filesrc location=$folder/in blocksize=4 ! application/octet-stream !
    tensor_converter input-dim=4 input-type=uint8 ! tensor_filter model=\"$1\" isolate=$place !
    filesink location=$folder/out" > "$folder/output" 2>&1 || { cat "$folder/output" && exit 1; }
  cmp -s "$folder/expected" "$folder/out" || {
    printf 'With isolate=%s, the filter did not return the expected bytes:\n' $place
    printf '  %-8s  %s\n' input "$(bytes in)" output "$(bytes out)" expected "$(bytes expected)"
    echo 'If the output is correct, change "expected" in test.sh.'
    exit 1
  } >&2
done
echo "my-filter works"
