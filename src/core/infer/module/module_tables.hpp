// ModuleTables: a module's tables in this host's layout, whichever version of the header the module
// was built with.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// Copies of the tables: members missing from older tables are null, additional members of newer
// ones are ignored. The module keeps what the tables point to.
class ModuleTables {
 public:
  // MODULE_REFUSED if check_module (module_check.hpp) fails.
  static Result<std::unique_ptr<ModuleTables>> copy(const weir_module* module,
                                                    const std::string& path);
  // Its lists are never null.
  const weir_module& module() const noexcept { return module_; }

 private:
  template <class Table>
  struct List {
    std::deque<Table> tables;
    std::vector<const Table*> pointers;
    void copy(const Table* const* from);
  };
  List<weir_engine> engines_;
  List<weir_decoder_type> decoders_;
  List<weir_converter_type> converters_;
  weir_module module_{};
};

}  // namespace weir::infer
