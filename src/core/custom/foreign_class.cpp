// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/foreign_class.hpp"

#include <atomic>

#include "core/process/process_object.hpp"
#include "core/subplugin/loader.hpp"

namespace weir::custom {
namespace {

struct Place {
  std::atomic<const weir_engine& (*)()> engine{nullptr};
};
Place& place() {
  static auto& one = process::object<Place>("nnstreamer-class-engine");
  return one;
}

}  // namespace

void set_class_engine(const weir_engine& (*engine)()) noexcept {
  place().engine = engine;
}

Result<const weir_engine*> class_engine() {
  if (auto status = subplugin::load_library(); !status) return status.error();
  const auto engine = place().engine.load();
  if (!engine)
    return Error{.code = Code::MODULE_REFUSED,
                 .what = "the library with the functions of NNStreamer is not Weir's",
                 .needed = "libnnstreamer.so of this version of Weir",
                 .fix = "WEIR_NNSTREAMER_LIBRARY=/path/to/libnnstreamer.so"};
  return &engine();
}

}  // namespace weir::custom
