// Users' scripts: loading a class of one, and the module nnstreamer_python that scripts import.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "interpreter.hpp"

namespace weir::python {

// Under Locked: an object of the class `class_name` of the script at `path`, made with these
// arguments. Each call runs the file anew, as a module of its own: scripts of one name in two
// folders do not meet. The script's folder and "." are searched for what it imports.
// FILE_NOT_FOUND; MODULE_REFUSED when the script fails or has no such class.
Result<Object> load_script(const std::string& path, const char* class_name,
                           std::vector<Object> arguments);

// Under Locked: the number of abi.h for a tensor's type, and its dimensions, of an object that has
// getType() and getDims() as TensorShape has. Our module of Python offers it as tensor_of(shape),
// which gives (type, dimensions without the zeros behind them), or raises. It calls each method
// once: a script may return something else the next time.
Result<PyObject*> script_names();

}  // namespace weir::python
