#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compiles the examples against an installed tree, only with the flags from pkg-config, and runs them.

The tree is in the build folder, below DESTDIR; the checkout's headers and libraries are not accessible.
"""

import importlib.machinery
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
BUILD = pathlib.Path(os.environ["WEIR_BUILD"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / ".." / "shared")
DESTDIR = BUILD / "tests" / "library" / "installed"
PREFIX = DESTDIR / os.environ["WEIR_PREFIX"].lstrip("/")
LIBRARIES = PREFIX / os.environ["WEIR_LIBDIR"]
GUIDES = [SOURCE / "docs" / "guide" / name for name in ("use-a-model.md", "use-a-pipeline.md")]
STRICT = ["-Wall", "-Wextra", "-Werror", "-pedantic"]


def run(*command, **more):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=600, check=False, **more)


def pkg_config(*arguments):
    """Runs pkg-config as a user's build does; the packages have their install prefix, and DESTDIR is prepended."""
    done = run("pkg-config", f"--define-variable=prefix={PREFIX}", *arguments,
               env={**os.environ, "PKG_CONFIG_PATH": str(LIBRARIES / "pkgconfig")})
    if done.returncode:
        raise AssertionError(done.stderr)
    return shlex.split(done.stdout)


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(DESTDIR, ignore_errors=True)
        done = run(SOURCE / "tools/install", BUILD, os.environ["WEIR_PREFIX"], env={**os.environ, "DESTDIR": str(DESTDIR)})
        if done.returncode:
            raise AssertionError(done.stdout + done.stderr)
        cls.folder = tempfile.TemporaryDirectory()
        model = pathlib.Path(cls.folder.name) / "any.model"
        model.write_text("x")
        cls.model = str(model)
        cls.programs = {}
        for source, package in {"model_once.cpp": "weir", "model_once.c": "weir",
                                "pipeline_push_pull.cpp": "weir-pipeline",
                                "application_api.c": "capi-ml-inference",
                                "custom_filter.cpp": "weir-pipeline", "custom_filter.c": "weir-pipeline"}.items():
            cls.programs[source] = cls.compile(SOURCE / "examples" / source, package)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_install_prints_the_settings_of_a_prefix_where_gstreamer_does_not_look(self):
        install = importlib.machinery.SourceFileLoader("install", str(SOURCE / "tools/install")).load_module()
        put = [f"/opt/w/{file}" for file in ("lib/gstreamer-1.0/libgstweir.so", "lib/pkgconfig/weir-module.pc", "bin/weir", "lib/libweir-pipeline.so",
                                             "lib/python3/dist-packages/weir/__init__.py")]
        self.assertEqual([line.strip() for line in install.settings_of_a_prefix("/opt/w", put).splitlines()[1:]],
                         ["export GST_PLUGIN_PATH=/opt/w/lib/gstreamer-1.0", "export PATH=/opt/w/bin:$PATH",
                          "export LD_LIBRARY_PATH=/opt/w/lib", "export PKG_CONFIG_PATH=/opt/w/lib/pkgconfig",
                          "export PYTHONPATH=/opt/w/lib/python3/dist-packages"])
        plugins = run("pkg-config", "--variable=pluginsdir", "gstreamer-1.0").stdout.strip()
        self.assertEqual(install.settings_of_a_prefix("/usr", [f"{plugins}/libgstweir.so"]), "")

    @classmethod
    def compile(cls, source, package, *more):
        program = pathlib.Path(cls.folder.name) / source.name.replace(".", "_")
        cxx = source.suffix == ".cpp"
        compiler = shlex.split(os.environ["WEIR_CXX" if cxx else "WEIR_CC"])
        standard = "-std=c++20" if cxx else "-std=c11"
        done = run(*compiler, standard, *STRICT, *more, source, "-o", program,
                   *pkg_config("--cflags", "--libs", package), cwd=cls.folder.name)
        if done.returncode:
            raise AssertionError(done.stderr)
        return program

    def start(self, program, *arguments, **environment):
        modules = [str(LIBRARIES / "weir" / "modules"), os.environ["WEIR_TEST_MODULES"]]
        env = {**os.environ, "LD_LIBRARY_PATH": str(LIBRARIES), "WEIR_MODULE_PATH": ":".join(modules),
               "GST_PLUGIN_PATH": str(LIBRARIES / "gstreamer-1.0"), "GST_REGISTRY": str(DESTDIR / "registry.bin"),
               "WEIR_WORKER": str(next(PREFIX.rglob("weir-worker"))), **environment}
        return run(self.programs[program], *arguments, env=env, cwd=self.folder.name)

    def test_debug_information_stays_in_the_build_folder(self):
        installed = [PREFIX / "bin" / "weir", LIBRARIES / "libweir.so.0", LIBRARIES / "gstreamer-1.0" / "libgstweir.so",
                     *(LIBRARIES / "weir" / "modules").glob("*.so")]
        for file in installed:
            self.assertNotIn(".debug_info", run("readelf", "-SW", file).stdout, file)
        self.assertIn(".debug_info", run("readelf", "-SW", BUILD / "src" / "plugin" / "libgstweir.so").stdout)

    def test_a_model_runs_from_cpp(self):
        done = self.start("model_once.cpp", self.model, "", "fake")
        self.assertEqual(done.stdout, "engine: fake\ninput: float32 (1, 4) x\noutput: float32 (1, 4) y\nlargest: 0, 1\n",
                         done.stderr)
        self.assertEqual(done.returncode, 0)

    def test_a_model_runs_from_c(self):
        done = self.start("model_once.c", self.model, "fake")
        self.assertEqual(done.stdout, "engine: fake\ninput x: 16 bytes\noutput y: 16 bytes\n", done.stderr)
        self.assertEqual(done.returncode, 0)

    def test_errors_are_reported(self):
        for program in ("model_once.cpp", "model_once.c"):
            done = self.start(program, "/no/such/file.onnx")
            self.assertEqual(done.returncode, 1, program)
            self.assertRegex(done.stderr, r"WEIR-300[23]: ", program)
        done = self.start("model_once.cpp", self.model, self.model, "fake")
        self.assertEqual(done.returncode, 1)
        self.assertIn("WEIR-2004: input 0 (x) has a size that does not match its shape\n  offered: 1 bytes", done.stderr)

    def test_frames_go_through_a_pipeline(self):
        done = self.start("pipeline_push_pull.cpp", "tensor_transform mode=arithmetic option=mul:2,add:1")
        self.assertEqual(done.stdout, "0 ms: 1 3 5 7\n100 ms: 3 5 7 9\n200 ms: 5 7 9 11\n", done.stderr)
        self.assertEqual(done.returncode, 0)

    def test_a_pipeline_runs_a_model(self):
        done = self.start("pipeline_push_pull.cpp", f"tensor_filter framework=fake model={self.model}")
        self.assertEqual(done.stdout, "0 ms: 1 2 3 4\n100 ms: 2 3 4 5\n200 ms: 3 4 5 6\n", done.stderr)

    def test_errors_in_a_pipeline_are_reported(self):
        done = self.start("pipeline_push_pull.cpp", "tensor_filtre")
        self.assertEqual(done.returncode, 1)
        self.assertIn("did you mean tensor_filter?", done.stderr)
        done = self.start("pipeline_push_pull.cpp", "tensor_filter framework=fake model=/no/such/model")
        self.assertEqual(done.returncode, 1)
        self.assertIn("WEIR-3003: ", done.stderr)

    def test_programs_of_the_application_api_find_all_they_need_with_each_package(self):
        # Each header alone, as published programs include it, and C99.
        common = "int main(void) { bool no = false; free(NULL); return no || ESTRPIPE != 86 || ml_error() || !ml_strerror(ML_ERROR_IO_ERROR); }"
        single = ("int main(void) { ml_single_h single; return ml_single_open(&single, \"/no/such\", NULL, NULL, ML_NNFW_TYPE_TENSORFLOW_LITE, "
                  "ML_NNFW_HW_ANY) != ML_ERROR_INVALID_PARAMETER || !ml_error(); }")
        pipeline = ("int main(void) { ml_pipeline_h pipe; bool yes = false; ml_check_element_availability(\"tensor_filter\", &yes); "
                    "if (ml_pipeline_construct(\"appsrc ! tensor_sink\", NULL, NULL, &pipe)) return 1; return ml_pipeline_destroy(pipe) || !yes; }")
        for package, header, text in (("capi-ml-common", "ml-api-common.h", common), ("capi-ml-common", "tizen_error.h", "int main(void) { return EIO + TIZEN_ERROR_IO_ERROR; }"),
                                      ("capi-ml-inference-single", "nnstreamer-single.h", single), ("capi-ml-inference", "nnstreamer.h", pipeline),
                                      ("capi-ml-inference", "nnstreamer-single.h", single), ("capi-nnstreamer", "nnstreamer.h", pipeline),
                                      ("nnstreamer-capi", "nnstreamer.h", common)):
            with self.subTest(f"{package} {header}"):
                source = pathlib.Path(self.folder.name) / "program_of_a_user.c"
                source.write_text(f"#include <{header}>\n{text}\n")
                self.programs["user"] = self.compile(source, package, "-std=c99")
                done = self.start("user")
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(run("pkg-config", "--modversion", LIBRARIES / "pkgconfig" / "capi-ml-inference.pc",
                             env={**os.environ, "PKG_CONFIG_PATH": str(LIBRARIES / "pkgconfig")}).stdout, "1.8.8\n")

    def test_a_binary_built_for_nnstreamers_libraries_runs(self):
        # Its symbols are in three libraries there, without versions.
        folder = pathlib.Path(self.folder.name)
        calls = {"capi-ml-common": "ml_option_create", "capi-ml-inference-single": "ml_single_close", "capi-nnstreamer": "ml_pipeline_start"}
        compiler = shlex.split(os.environ["WEIR_CC"])
        for library, call in calls.items():
            (folder / "stub.c").write_text(f"int {call}(void* x) {{ (void)x; return 77; }}\n")
            done = run(*compiler, "-shared", "-fPIC", folder / "stub.c", "-o", folder / f"lib{library}.so", f"-Wl,-soname,lib{library}.so.1")
            self.assertEqual(done.returncode, 0, done.stderr)
        (folder / "old.c").write_text("".join(f"int {call}(void*);\n" for call in calls.values()) + "int main(void) { return " +
                                      " || ".join(f"{call}(0) != -22" for call in calls.values()) + "; }\n")
        self.programs["old"] = folder / "old"
        done = run(*compiler, folder / "old.c", "-o", folder / "old", f"-L{folder}", *(f"-l{library}" for library in calls))
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.start("old")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        # One for single models needs only these two, which have no function of their own here.
        two = ("capi-ml-common", "capi-ml-inference-single")
        (folder / "old.c").write_text("".join(f"int {calls[library]}(void*);\n" for library in two) + "int main(void) { return " +
                                      " || ".join(f"{calls[library]}(0) != -22" for library in two) + "; }\n")
        done = run(*compiler, folder / "old.c", "-o", folder / "old", f"-L{folder}", *(f"-l{library}" for library in two))
        self.assertEqual(done.returncode, 0, done.stderr)
        needed = run("readelf", "-d", folder / "old").stdout
        self.assertNotIn("capi-nnstreamer", needed)
        for library in two:
            self.assertIn(f"lib{library}.so.1", needed)
        done = self.start("old")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_program_on_nnstreamers_application_api_runs(self):
        done = self.start("application_api.c", "tensor_filter framework=custom-easy model=twice")
        self.assertEqual(done.stdout, "42 1 \n0 1 \n2 1 \n4 1 \n", done.stderr)
        self.assertEqual(done.returncode, 0)
        self.expect_words("application_api.c", "tensor_filter framework=custom-easy model=twise", "did you mean twice?")
        self.expect_words("application_api.c", "tensor_filtre", "did you mean tensor_filter?")

    def expect_output(self, program, element, expected):
        done = self.start(program, element)
        self.assertEqual((done.stdout, done.returncode), (expected, 0), done.stderr)

    def expect_words(self, program, element, *words):
        done = self.start(program, element)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        output = re.sub(r"weirtensorfilter\d+: ", "", done.stderr)
        for part in words:
            self.assertIn(part, output)

    def test_filters_of_the_program_run_by_name(self):
        easy = "tensor_filter framework=custom-easy model="
        self.expect_output("custom_filter.cpp", easy + "doubler", "-4 -2 0 2 \n-2 0 2 4 \n0 2 4 6 \n")
        self.expect_output("custom_filter.cpp", easy + "positive invoke-dynamic=true", "1 \n1 2 \n1 2 3 \n")
        self.expect_output("custom_filter.cpp", easy + "doubler ! tensor_filter framework=cpp model=Power custom=exponent:3",
                           "-64 -8 0 8 \n-8 0 8 64 \n0 8 64 216 \n")
        self.expect_output("custom_filter.c", easy + "step", "11 12 13 14 \n")

    def test_filters_of_the_program_are_refused_with_a_reason(self):
        easy = "tensor_filter framework=custom-easy model="
        self.expect_words("custom_filter.cpp", easy + "dubler", "WEIR-5002", "one of: doubler, odd, positive",
                          "did you mean doubler?")
        self.expect_words("custom_filter.cpp", easy + "positive", "WEIR-1004: the filter positive decides its sizes")
        self.expect_words("custom_filter.cpp", easy + "odd", "WEIR-5003: the filter odd failed: the third frame is too much")
        self.expect_words("custom_filter.cpp", easy + "doubler isolate=process",
                          "a function of this program cannot run in another process")
        self.expect_words("custom_filter.cpp", "tensor_filter framework=cpp model=Power isolate=process",
                          "a class of this program cannot run in another process", "model=Power,/path/to/lib.so")
        self.expect_words("custom_filter.c", "tensor_filter framework=custom-easy model=stop", "did you mean step?")
        self.expect_words("custom_filter.c", "tensor_filter framework=cpp model=step", "no filter class has this name",
                          "one of: none")

    def build_library(self, source, *packages):
        library = pathlib.Path(self.folder.name) / source.name.replace(".cpp", ".so")
        done = run(*shlex.split(os.environ["WEIR_CXX"]), "-std=c++20", *STRICT, "-shared", "-fPIC", "-fvisibility=hidden",
                   source, "-o", library, *pkg_config("--cflags", "--libs", *packages))
        self.assertEqual(done.returncode, 0, done.stderr)
        return library

    def test_libraries_bring_filters(self):
        """In this process and in a worker: a class that registers itself, and modules of Weir's interface."""
        outside = SOURCE / "tests" / "abi" / "outside"
        line = self.build_library(outside / "filter_class.cpp", "weir")
        module = self.build_library(outside / "every_part.cpp", "weir-module")
        once = "0 ms: {}\n100 ms: {}\n200 ms: {}\n".format
        for more in ("", " isolate=process"):
            with self.subTest(more):
                self.expect_output("pipeline_push_pull.cpp", f"tensor_filter framework=cpp model=Line,{line} custom=a:1,b:2{more}",
                                   once("1 3 5 7", "3 5 7 9", "5 7 9 11"))
                for named in (f"framework=custom model={module}", f"model={module}", f"framework=cpp model=outside-cpp,{module}"):
                    self.expect_output("pipeline_push_pull.cpp", f"tensor_filter {named} custom=factor:3{more}",
                                       once("0 3 6 9", "3 6 9 12", "6 9 12 15"))
                self.expect_words("pipeline_push_pull.cpp", f"tensor_filter framework=cpp model=line,{line}{more}",
                                  "WEIR-5002: no filter class has this name", "did you mean Line?")
                self.expect_words("pipeline_push_pull.cpp", f"tensor_filter framework=custom model={line}{more}",
                                  "WEIR-3007: the file has no engine of its own", f"framework=cpp model=NAME,{line}")

    def test_python_finds_the_package(self):
        if not os.environ["WEIR_PYTHON_DIR"]:
            self.skipTest("the package for Python is not built")
        folder = DESTDIR / os.environ["WEIR_PYTHON_DIR"].lstrip("/")
        program = ("import sys, numpy, weir, nnstreamer_python; model = weir.Model(sys.argv[1], engine='fake')\n"
                   "print(model.invoke(numpy.zeros((1, 4), 'f4'))[0].tolist(), nnstreamer_python.TensorShape([3]).dims[0])")
        env = {**os.environ, "PYTHONPATH": str(folder), "LD_LIBRARY_PATH": str(LIBRARIES),
               "WEIR_MODULE_PATH": os.environ["WEIR_TEST_MODULES"]}
        done = run("/usr/bin/python3", "-c", program, self.model, env=env, cwd=self.folder.name)
        self.assertEqual(done.stdout, "[[1.0, 1.0, 1.0, 1.0]] 3\n", done.stderr)
        looked = run("/usr/bin/python3", "-c", "import site; print(site.getsitepackages())").stdout
        if os.environ["WEIR_PREFIX"] in ("/usr", "/usr/local"):
            self.assertIn(f"'{os.environ['WEIR_PYTHON_DIR']}'", looked)

    def test_a_library_is_found_by_the_name_of_its_filter(self):
        self.build_library(SOURCE / "tests" / "abi" / "outside" / "halved.cpp", "weir")
        for more in ("", " isolate=process"):
            with self.subTest(more):
                done = self.start("pipeline_push_pull.cpp", f"tensor_filter framework=custom-easy model=halved{more}",
                                  WEIR_FILTER_PATH=self.folder.name)
                self.assertEqual(done.stdout, "0 ms: 0 0.5 1 1.5\n100 ms: 0.5 1 1.5 2\n200 ms: 1 1.5 2 2.5\n", done.stderr)

    def test_a_library_whose_name_is_taken_ends_no_program(self):
        line = self.build_library(SOURCE / "tests" / "abi" / "outside" / "filter_class.cpp", "weir")
        second = shutil.copy(line, line.with_name("second.so"))
        # Elements change state from last to first.
        self.expect_words("pipeline_push_pull.cpp", f"tensor_filter framework=cpp model=Linear,{second} ! "
                          f"tensor_filter framework=cpp model=Line,{line}",
                          "another class has this name", "WEIR-5002: no filter class has this name")

    def test_the_plugin_finds_the_library_by_itself(self):
        env = {**os.environ, "GST_PLUGIN_PATH": str(LIBRARIES / "gstreamer-1.0"), "GST_REGISTRY_FORK": "no",
               "GST_REGISTRY": str(DESTDIR / "inspect.bin")}
        env.pop("LD_LIBRARY_PATH", None)
        done = run("gst-inspect-1.0", "tensor_filter", env=env)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(str(LIBRARIES / "gstreamer-1.0" / "libgstweir.so"), done.stdout)

    def test_pipelines_need_no_header_of_gstreamer(self):
        flags = pkg_config("--cflags", "weir-pipeline")
        program = run(*shlex.split(os.environ["WEIR_CXX"]), "-std=c++20", "-E", "-M", f"-I{PREFIX}/include",
                      SOURCE / "examples" / "pipeline_push_pull.cpp")
        self.assertEqual(program.returncode, 0, program.stderr)
        self.assertNotRegex(program.stdout, r"/(gst|glib-2\.0|glib)/")
        self.assertIn(f"-I{PREFIX}/include", flags)
        self.assertNotRegex(" ".join(pkg_config("--libs", "weir-pipeline")), r"-lgst|-lglib")

    def test_a_network_sees_the_orange(self):
        model = SHARED / "models" / "classification" / "mobilenet_v1_0.25_224_quant.tflite"
        picture = SHARED / "media" / "image" / "orange.raw"
        if not (model.exists() and picture.exists()):
            self.skipTest("the real models are not there")
        if not (LIBRARIES / "weir" / "modules" / "libweir-engine-tensorflow-lite.so").exists():
            self.skipTest("the engine tensorflow-lite is not built")
        done = self.start("model_once.cpp", model, picture)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"input: uint8 \(1, 224, 224, 3\)")
        self.assertRegex(done.stdout, r"largest: 951, \d+\n")

    def test_a_network_runs_from_c(self):
        model = SHARED / "models" / "classification" / "mnist.onnx"
        if not model.exists():
            self.skipTest("the real models are not there")
        if not (LIBRARIES / "weir" / "modules" / "libweir-engine-onnxruntime.so").exists():
            self.skipTest("the engine onnxruntime is not built")
        done = self.start("model_once.c", model)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("bytes\noutput Plus214_Output_0: 40 bytes\n", done.stdout)

    def test_what_the_guides_show_compiles(self):
        """Each C++ block of the guides compiles as the body of a function that returns int."""
        count = 0
        for guide in GUIDES:
            package = "weir-pipeline" if "pipeline" in guide.name else "weir"
            for block in re.findall(r"```cpp\n(.*?)```", guide.read_text(), re.DOTALL):
                count += 1
                source = pathlib.Path(self.folder.name) / f"guide_{count}.cpp"
                source.write_text('#include <cstdio>\n#include <numeric>\n#include "weir/model.hpp"\n'
                                  + ('#include "weir/pipeline.hpp"\n' if package == "weir-pipeline" else "")
                                  + "int complain(const weir::Error& e) { return std::puts(e.message().c_str()), 1; }\n"
                                  + "using namespace std::chrono_literals;\n"
                                  + f"int show() {{\n{block}\nreturn 0;\n}}\nint main() {{ return 0 * sizeof(&show); }}\n")
                with self.subTest(guide=guide.name, block=block):
                    self.compile(source, package, "-Wno-unused-variable", "-Wno-unused-but-set-variable")
        self.assertGreater(count, 5)


if __name__ == "__main__":
    tap_runner.main()
