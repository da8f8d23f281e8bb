// The first file is the engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/custom_module.hpp"

#include "core/custom/filter_library.hpp"
#include "core/custom/foreign_class.hpp"
#include "core/custom/forwarding_engine.hpp"

namespace weir::custom {
namespace {

Error without_engine(const std::string& path) {
  return Error{Code::MODULE_REFUSED,
               "the file has no engine of its own",
               path,
               "weir_module_entry with an engine",
               "",
               "framework=cpp model=NAME," + path};
}

Error several_engines(const std::string& path, const weir_engine* const* engines) {
  std::string names;
  for (auto* each = engines; *each; ++each)
    names += (names.empty() ? "" : ", ") + std::string((*each)->name);
  return Error{Code::OPTION_VALUE,
               "the file has several engines",
               path + ": " + names,
               "one of them by name",
               "",
               "framework=cpp model=" + std::string(engines[0]->name) + "," + path};
}

Result<FoundEngine> find(const weir_open& request) {
  if (request.n_models == 0)
    return Error{Code::MODEL_NOT_FOUND,
                 "no file is named",
                 "model=\"\"",
                 "model=lib.so",
                 "",
                 "framework=custom model=/path/to/lib.so"};
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
    return Error{Code::MODEL_NOT_FOUND,
                 "the engine in this file needs a model of its own",
                 "model=" + path,
                 "the model's file behind it",
                 "",
                 "model=" + path + ",/path/to/the/model"};
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
