// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/module_tables.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "core/infer/module/module_check.hpp"

namespace weir::infer {
namespace {

// check_module() requires every member before the optional ones, which are all pointers: a table
// that ends within one of them does not have it.
template <class Table>
Table as_long_as_ours(const Table& theirs) {
  Table ours{};
  const size_t whole_members = theirs.struct_size / sizeof(void*) * sizeof(void*);
  std::memcpy(&ours, &theirs, std::min(whole_members, sizeof ours));
  ours.struct_size = sizeof ours;
  return ours;
}
static_assert(offsetof(weir_engine, submit) % sizeof(void*) == 0 &&
              offsetof(weir_decoder_type, extension) % sizeof(void*) == 0 &&
              offsetof(weir_converter_type, extension) % sizeof(void*) == 0 &&
              offsetof(weir_module, trainers) % sizeof(void*) == 0);

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
