// The module table of the built-in engines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/builtin_engines.hpp"

#include "core/custom/custom_easy.hpp"
#include "core/custom/custom_module.hpp"
#include "core/custom/filter_class.hpp"

namespace weir::custom {

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
