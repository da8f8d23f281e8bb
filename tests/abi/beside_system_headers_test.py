#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests that the headers of include/weir compile after and before those of the system, GLib and GStreamer: no name is a macro there."""

import os
import pathlib
import shlex
import subprocess
import unittest

import tap_runner

HEADERS = pathlib.Path(os.environ["WEIR_SOURCE"]) / "include"
STRICT = ["-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-D_GNU_SOURCE"]
SYSTEM = """arpa/inet.h assert.h complex.h ctype.h dirent.h dlfcn.h elf.h endian.h errno.h fcntl.h fenv.h float.h fnmatch.h ftw.h
getopt.h glob.h grp.h inttypes.h langinfo.h limits.h link.h linux/dma-buf.h linux/input.h linux/landlock.h linux/seccomp.h
linux/videodev2.h locale.h malloc.h math.h mntent.h net/if.h netdb.h netinet/in.h netinet/tcp.h poll.h pthread.h pwd.h regex.h
resolv.h sched.h search.h semaphore.h setjmp.h signal.h spawn.h stdio.h stdlib.h string.h sys/epoll.h sys/eventfd.h sys/file.h
sys/inotify.h sys/ioctl.h sys/ipc.h sys/mman.h sys/mount.h sys/msg.h sys/param.h sys/personality.h sys/prctl.h sys/ptrace.h
sys/random.h sys/resource.h sys/select.h sys/sem.h sys/sendfile.h sys/shm.h sys/signalfd.h sys/socket.h sys/stat.h sys/statvfs.h
sys/syscall.h sys/sysinfo.h sys/sysmacros.h sys/time.h sys/timerfd.h sys/times.h sys/types.h sys/uio.h sys/un.h sys/user.h
sys/utsname.h sys/vfs.h sys/wait.h sys/xattr.h syslog.h termios.h time.h ucontext.h unistd.h utime.h utmpx.h wchar.h wctype.h
wordexp.h glib.h glib-object.h gio/gio.h glib-unix.h gst/gst.h gst/allocators/gstdmabuf.h gst/app/app.h gst/audio/audio.h
gst/base/base.h gst/video/video.h""".split()


def gstreamer():
    packages = ["gstreamer-1.0", "gstreamer-app-1.0", "gstreamer-video-1.0", "gstreamer-audio-1.0", "gstreamer-allocators-1.0",
                "gio-unix-2.0"]
    output = subprocess.run(["pkg-config", "--cflags", *packages], capture_output=True, text=True, check=True)
    return [word.replace("-I", "-isystem", 1) for word in shlex.split(output.stdout)]


def compiles(language, standard, compiler, names):
    source = "".join(f"#include <{name}>\n" for name in names)
    source += ("const int code = WEIR_MAPPING_FAILED;\n"
               "const void* const system_value = MAP_FAILED;\n")
    if language == "c++":
        source += "static_assert(static_cast<int>(weir::Code::MAPPING_FAILED) == 2007);\n"
    return subprocess.run([*shlex.split(compiler), "-x", language, f"-std={standard}", *STRICT, "-I", HEADERS, *gstreamer(), "-"],
                          input=source, capture_output=True, text=True, check=False)


class BesideSystemHeaders(unittest.TestCase):
    def expect_both_orders(self, language, standard, variable, pattern):
        ours = sorted(f"weir/{path.name}" for path in (HEADERS / "weir").glob(pattern))
        self.assertIn("weir/codes.h", ours)
        for order in (SYSTEM + ours, ours + SYSTEM):
            done = compiles(language, standard, os.environ[variable], order)
            self.assertEqual(done.returncode, 0, f"{order[0]} first\n{done.stderr}")

    def test_in_c(self):
        self.expect_both_orders("c", "c11", "WEIR_CC", "*.h")

    def test_in_cpp(self):
        self.expect_both_orders("c++", "c++20", "WEIR_CXX", "*.h*")


if __name__ == "__main__":
    tap_runner.main()
