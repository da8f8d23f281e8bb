// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scripts.hpp"

#include <filesystem>

#include "tensor_shape_text.hpp"

namespace weir::python {
namespace {

constexpr char kScripts[] = R"py(
import importlib.util, os, sys, types
import numpy
from weir_tensor_shape import MOST_DIMENSIONS, TensorShape

if "weir" in sys.modules:  # the program's own
    TensorShape = sys.modules["weir"].TensorShape

TYPES = {numpy.dtype(name): number for number, name in enumerate(
    ("int32", "uint32", "int16", "uint16", "int8", "uint8", "float64", "float32", "int64",
     "uint64", "float16"))}
DTYPES = {number: dtype for dtype, number in TYPES.items()}
loaded = 0
modules = {}  # name of the module of each script, by id() of its object

names = types.ModuleType("nnstreamer_python")
names.TensorShape = TensorShape
sys.modules.setdefault("nnstreamer_python", names)

# The package for programs, where it is installed; for scripts the class alone will do.
if importlib.util.find_spec("weir") is None:
    package = types.ModuleType("weir")
    package.TensorShape = TensorShape
    sys.modules["weir"] = package

def load(path, class_name, *arguments):
    global loaded
    path = os.path.abspath(path)
    # Only the script's own folder: the working directory may hold the files of anyone.
    if os.path.dirname(path) not in sys.path:
        sys.path.append(os.path.dirname(path))
    loaded += 1
    module = types.ModuleType(f"weir_script_{loaded}")
    module.__file__ = path
    sys.modules[module.__name__] = module
    try:
        with open(path, "rb") as file:
            exec(compile(file.read(), path, "exec"), module.__dict__)
        if class_name not in module.__dict__:
            raise AttributeError(f"the script has no class {class_name}")
        script = module.__dict__[class_name](*arguments)
    except BaseException:
        del sys.modules[module.__name__]
        raise
    modules[id(script)] = module.__name__
    return script

def unload(script):
    sys.modules.pop(modules.pop(id(script), None), None)

def whole(number):
    value = int(number)
    if value != float(number):
        raise ValueError(f"a dimension is an integer, not {number}")
    return value

# By its real type: an object may report any other as its __class__.
def is_a(kind, value):
    return issubclass(type(value), kind)

def to_tensor(shape):
    dtype = numpy.dtype(shape.getType())
    if dtype not in TYPES:
        raise TypeError(f"{dtype} is not a tensor type, which is one of {', '.join(map(str, TYPES))}")
    dims = [whole(d) for d in shape.getDims()]
    while dims and dims[-1] == 0:
        dims.pop()
    if not dims or min(dims) < 1 or max(dims) >= 1 << 32 or len(dims) > MOST_DIMENSIONS:
        raise ValueError(f"a tensor has 1 to 16 dimensions of at least 1, not {dims}")
    return TYPES[dtype], tuple(dims)
)py";

}  // namespace

Result<PyObject*> script_names() {
  if (const auto shape = module_of_ours("weir_tensor_shape", kTensorShape); !shape)
    return shape.error();
  return module_of_ours("weir_scripts", kScripts);
}

Result<Object> load_script(const std::string& path, const char* class_name,
                           std::vector<Object> arguments) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored))
    return Error{.code = Code::FILE_NOT_FOUND,
                 .what = "the script does not exist",
                 .offered = path,
                 .needed = "a file with Python's source text"};
  const auto names = script_names();
  if (!names) return names.error();
  std::vector<Object> all;
  all.push_back(make_text(path));
  all.push_back(make_text(class_name));
  for (auto& argument : arguments) all.push_back(std::move(argument));
  auto loaded = call(*names, "load", std::move(all), Code::MODULE_REFUSED);
  if (loaded) return loaded;
  Error error = loaded.error();
  if (error.offered.empty()) error.offered = path;  // the error has no traceback into the script
  return error;
}

void unload_script(Object script) {
  const auto names = script_names();
  if (!names || !script) return;
  std::vector<Object> arguments;
  arguments.push_back(std::move(script));
  static_cast<void>(call(*names, "unload", std::move(arguments), Code::INTERNAL));
}

}  // namespace weir::python
