// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/process_bound.hpp"

#include "core/custom/filter_library.hpp"

namespace weir::custom {

std::optional<Error> bound_to_this_process(const std::string& engine,
                                           std::span<const std::string> paths) {
  const std::string name = paths.empty() ? "" : paths[0];
  const std::string offered = "framework=" + engine + " model=" + name + " isolate=process";
  if (engine == "custom-easy" && library_of_filter(name).empty())
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "a function of this program cannot run in another process",
        .offered = offered,
        .needed = "isolate=none, or the filter as a shared object: framework=custom model=lib.so",
        .fix = "tensor_filter framework=custom-easy model=" + name + " isolate=none"};
  if (engine == "cpp" && paths.size() == 1)
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "a class of this program cannot run in another process",
        .offered = offered,
        .needed = "isolate=none, or the library that provides the class",
        .fix = "tensor_filter framework=cpp model=" + name + ",/path/to/lib.so isolate=process"};
  return std::nullopt;
}

}  // namespace weir::custom
