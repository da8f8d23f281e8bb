// Loads a class from a user's script, and provides the module nnstreamer_python.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "interpreter.hpp"

namespace weir::python {

// Returns an instance of `class_name` of the script at `path`, made with these arguments. Call
// under Locked. Each call runs the file again as a separate module, so scripts with the same name
// in two folders do not clash. Imports are searched in the script's folder and ".". FILE_NOT_FOUND;
// MODULE_REFUSED when the script fails or has no such class.
Result<Object> load_script(const std::string& path, const char* class_name,
                           std::vector<Object> arguments);

// Releases what load_script() returned, and the module of the script. Call under Locked.
void unload_script(Object script);

// Returns our Python module's dict. Its to_tensor(shape) calls getType() and getDims() of an object
// such as TensorShape, and returns (type number of abi.h, dimensions without trailing zeros) or
// raises. It calls each method once, because a script may return something else the next time. Call
// under Locked.
Result<PyObject*> script_names();

}  // namespace weir::python
