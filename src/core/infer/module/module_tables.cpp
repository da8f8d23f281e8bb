// Copies tables up to their struct_size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/module_tables.hpp"

#include <algorithm>
#include <cstring>

#include "core/infer/module/module_check.hpp"

namespace weir::infer {
namespace {

template <class Table>
Table as_long_as_ours(const Table& theirs) {
  Table ours{};
  std::memcpy(&ours, &theirs, std::min<size_t>(theirs.struct_size, sizeof ours));
  ours.struct_size = sizeof ours;
  return ours;
}

}  // namespace

template <class Table>
void ModuleTables::List<Table>::copy(const Table* const* from) {
  for (; from && *from; ++from) pointers.push_back(&tables.emplace_back(as_long_as_ours(**from)));
  pointers.push_back(nullptr);
}

Result<std::unique_ptr<ModuleTables>> ModuleTables::copy(const weir_module* module,
                                                         const std::string& path) {
  if (auto status = check_module(module, path); !status) return status.error();
  auto out = std::make_unique<ModuleTables>();
  out->module_ = as_long_as_ours(*module);
  out->engines_.copy(module->engines);
  out->decoders_.copy(module->decoders);
  out->converters_.copy(module->converters);
  out->module_.engines = out->engines_.pointers.data();
  out->module_.decoders = out->decoders_.pointers.data();
  out->module_.converters = out->converters_.pointers.data();
  return out;
}

}  // namespace weir::infer
