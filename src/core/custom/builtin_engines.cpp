// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/builtin_engines.hpp"

#include <memory>
#include <new>
#include <span>
#include <string_view>

#include "core/custom/custom_easy.hpp"
#include "core/custom/filter_library.hpp"
#include "core/custom/filter_name.hpp"
#include "core/custom/foreign_class.hpp"
#include "core/custom/forwarding_engine.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/module_check.hpp"
#include "core/infer/module/named_objects.hpp"
#include "core/process/process_object.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "weir/custom_filter.h"
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

using Tables = std::shared_ptr<const infer::ModuleTables>;
using Classes = infer::NamedObjects<Tables>;
Classes& classes() {
  static auto& all = process::object<Classes>("filter-classes");
  return all;
}

const weir_engine* engine_called(const infer::ModuleTables& tables, std::string_view name) {
  for (auto* each = tables.module().engines; *each; ++each)
    if ((*each)->name == name) return *each;
  return nullptr;
}

Error unknown(const std::string& name, const std::string& library) {
  const std::string close = nearest(name, classes().names());
  const std::string library_option = library.empty() ? "" : "," + library;
  const std::string fix = !close.empty()    ? "framework=cpp model=" + close + library_option
                          : library.empty() ? "framework=cpp model=" + name + ",/path/to/lib.so"
                                            : "WEIR_FILTER_CLASS or WEIR_ENGINE in the library";
  return Error{.code = Code::CALLBACK_UNKNOWN,
               .what = "no filter class has this name",
               .offered = "framework=cpp model=" + name + library_option,
               .needed = classes().one_of() +
                         (library.empty() ? "" : "; or an engine of this name in " + library),
               .difference = close.empty() ? "" : "did you mean " + close + "?",
               .fix = fix};
}

Result<FoundEngine> find_class_engine(const weir_open& request) {
  if (request.n_models < 1 || request.n_models > 2)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "a filter class has a name and optionally a library",
                 .offered = std::to_string(request.n_models) + " parts in model=",
                 .needed = "model=NAME or model=NAME,lib.so",
                 .fix = "framework=cpp model=NAME,/path/to/lib.so"};
  const std::string name = request.paths[0];
  const std::string library = request.n_models == 2 ? request.paths[1] : "";
  const auto registered = [&]() -> FoundEngine {
    const auto found = classes().find(name);
    if (!found) return {};
    return {(*found)->module().engines[0], *found, request.n_models};
  };
  if (auto found = registered(); found.engine) return found;
  if (library.empty()) return unknown(name, library);
  const auto tables = open_filter_library(library);
  if (!tables) return tables.error();
  if (auto found = registered(); found.engine) return found;
  const auto* engine = *tables ? engine_called(**tables, name) : nullptr;
  if (!engine) return unknown(name, library);
  return FoundEngine{engine, *tables, request.n_models};
}

Error refused_class(const std::string& name, const std::string& why, const std::string& needed) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "the filter class " + name + " cannot be registered",
               .offered = why,
               .needed = needed};
}

Status add(const std::string& name, const weir_module* (*entry)(const weir_host*)) {
  if (!can_be_a_name(name)) return refused_class('"' + name + '"', "its name", kNameNeeded);
  if (!entry) return refused_class(name, "no entry", "the function that returns its engine");
  if (classes().find(name)) return refused_class(name, "another class has this name", kNameFree);
  auto tables = infer::ModuleTables::copy(entry(&infer::host()), name);
  if (!tables) return tables.error();
  const auto* engines = (*tables)->module().engines;
  if (!engines[0] || engines[1])
    return infer::module_refused(name, engines[0] ? "several engines" : "no engine", "one engine");
  if (!classes().add(name, *std::move(tables)))
    return refused_class(name, "another class has this name", kNameFree);
  return ok();
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

const weir_engine& cpp_engine() {
  static const weir_engine kTable = [] {
    weir_engine table = forwarding_table<find_class_engine>();
    table.name = "cpp";
    table.flags = WEIR_ENGINE_MODEL_IS_NO_FILE;
    return table;
  }();
  return kTable;
}

const weir_module& builtin_engines() {
  static const weir_engine* const engines[] = {&custom_engine(), &custom_easy_engine(),
                                               &cpp_engine(), nullptr};
  static const weir_module module{sizeof(weir_module),
                                  WEIR_ABI_MAJOR,
                                  WEIR_ABI_MINOR,
                                  engines,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr};
  return module;
}

}  // namespace weir::custom

int weir_filter_class_register(const char* name, const weir_module* (*entry)(const weir_host*),
                               weir_error** error) {
  return weir::custom::to_return_code(error,
                                      [&] { return weir::custom::add(name ? name : "", entry); });
}

int weir_filter_class_unregister(const char* name) {
  const auto removed = weir::custom::classes().remove(name ? name : "");
  return removed ? WEIR_OK : -WEIR_CALLBACK_UNKNOWN;
}
