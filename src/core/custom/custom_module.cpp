// Takes the engine from the first file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/custom_module.hpp"

#include <span>

#include "core/custom/filter_library.hpp"
#include "core/custom/foreign_class.hpp"
#include "core/custom/forwarding_engine.hpp"
#include "core/text/pasted.hpp"
#include "weir/join.hpp"

namespace weir::custom {
namespace {

Error without_engine(const std::string& path) {
  return Error{.code = Code::MODULE_REFUSED,
               .what = "the file has no engine of its own",
               .offered = path,
               .needed = "weir_module_entry with an engine",
               .fix = "framework=cpp model=" + launch_value("NAME," + path)};
}

Error several_engines(const std::string& path, const weir_engine* const* engines) {
  size_t count = 0;
  while (engines[count]) ++count;
  const std::string names =
      join(std::span(engines, count), ", ", [](const weir_engine* engine) { return engine->name; });
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "the file has several engines",
      .offered = path + ": " + names,
      .needed = "one of them by name",
      .fix = "framework=cpp model=" + launch_value(std::string(engines[0]->name) + "," + path)};
}

Result<FoundEngine> find(const weir_open& request) {
  if (request.n_models == 0)
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = "no file is named",
                 .offered = "model=\"\"",
                 .needed = "model=lib.so",
                 .fix = "framework=custom model=/path/to/lib.so"};
  const std::string path = request.paths[0];
  const auto foreign = has_callbacks(path);
  if (!foreign) return foreign.error();
  if (*foreign) {
    const auto engine = class_engine();
    if (!engine) return engine.error();
    return FoundEngine{*engine, nullptr, 0};
  }
  auto tables = open_filter_library(path);
  if (!tables) return tables.error();
  if (!*tables || !(*tables)->module().engines[0]) return without_engine(path);
  const auto* engines = (*tables)->module().engines;
  if (engines[1]) return several_engines(path, engines);
  if (request.n_models == 1 && (engines[0]->flags & WEIR_ENGINE_NEEDS_NO_MODEL) == 0)
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = "the engine in this file needs a model file",
                 .offered = "model=" + path,
                 .needed = "the path of the model file after the library",
                 .fix = "model=" + launch_value(path + ",/path/to/the/model")};
  return FoundEngine{engines[0], *tables, 1};
}

}  // namespace

const weir_engine& custom_engine() {
  static const weir_engine kTable = [] {
    weir_engine table = forwarding_table<find>();
    table.name = "custom";
    table.extensions = "so";
    return table;
  }();
  return kTable;
}

}  // namespace weir::custom
