#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes what protoc makes of .proto files, a FileDescriptorSet, as the initializer of an array: PROTOC ROOT OUTPUT PROTO..."""

import pathlib
import subprocess
import sys

protoc, root, output, *protos = sys.argv[1:]
names = [str(pathlib.Path(proto).resolve().relative_to(pathlib.Path(root).resolve())) for proto in protos]
made = pathlib.Path(output).with_suffix(".pb")
subprocess.run([protoc, "-I", root, f"--descriptor_set_out={made}", *names], check=True)
pathlib.Path(output).write_text(",".join(map(str, made.read_bytes())) + "\n")
