// Whether a framework supports an accelerator: queries sub-plugins, reads the lists of Weir's
// engines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "compat/guard.hpp"
#include "compat/properties.hpp"
#include "core/infer/module/accelerator.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/subplugin/loader.hpp"
#include "nnstreamer_plugin_api_filter.h"

using namespace weir::compat;

namespace {

bool in_list(const accl_hw* list, int count, accl_hw hw) {
  return list && std::find(list, list + std::max(count, 0), hw) != list + std::max(count, 0);
}

// Asks the sub-plugin about its options; one that does not know the event has no objection.
bool agrees(int result) {
  return result == 0 || result == -ENOENT;
}

bool has_v1(const GstTensorFilterFramework& framework, accl_hw hw, const gchar* custom) {
  const weir::OpenRequest nothing{{}, weir::Options(nullptr, 0), "", 0};
  Properties properties("", "", nothing);
  GstTensorFilterFrameworkInfo info{};
  if (framework.getFrameworkInfo(&framework, properties.get(), nullptr, &info) < 0) return false;
  const bool is_listed = in_list(info.hw_list, info.num_hw, hw);
  if (!custom) return is_listed;
  GstTensorFilterFrameworkEventData data{};
  data.hw = hw;
  data.custom = custom;
  const int result =
      framework.eventHandler(&framework, properties.get(), nullptr, CHECK_HW_AVAILABILITY, &data);
  return is_listed ? agrees(result) : result == 0;  // hardware of one option need not be listed
}

bool has_v0(const GstTensorFilterFramework& framework, accl_hw hw, const gchar* custom) {
  if (!framework.checkAvailability || framework.checkAvailability(hw) != 0) return false;
  GstTensorFilterFrameworkEventData data{};
  data.hw = hw;
  data.custom = custom;
  return !custom || !framework.handleEvent ||
         agrees(framework.handleEvent(CHECK_HW_AVAILABILITY, &data));
}

bool has(const GstTensorFilterFramework& framework, accl_hw hw, const gchar* custom) {
  return framework.version >> 16 & 0xFFFF ? has_v1(framework, hw, custom)
                                          : has_v0(framework, hw, custom);
}

// An engine without a list runs on the CPU.
bool has(const weir_engine& engine, accl_hw hw) {
  const auto names = weir::infer::list_accelerators(engine);
  if (names.empty()) return hw == ACCL_CPU;
  return std::any_of(names.begin(), names.end(), [&](const auto& name) {
    return weir::infer::accelerator_number(name) == static_cast<unsigned>(hw);
  });
}

}  // namespace

gboolean gst_tensor_filter_check_hw_availability(const gchar* name, const accl_hw hw,
                                                 const gchar* custom) {
  if (!given(__func__, {name}) || hw == ACCL_NONE) return FALSE;
  return or_else(__func__, FALSE, [&]() -> gboolean {
    using weir::subplugin::Kind;
    const auto sub_plugin = weir::subplugin::open(Kind::Filter, name);
    const bool is_any = hw == ACCL_AUTO || hw == ACCL_DEFAULT;
    if (sub_plugin && *sub_plugin)
      return is_any || has(*static_cast<const GstTensorFilterFramework*>(*sub_plugin), hw, custom);
    const auto engine = weir::infer::ModuleLibrary::instance().engine(name);
    if (engine) return is_any || has(**engine, hw);
    warn("gst_tensor_filter_check_hw_availability", engine.error());
    return FALSE;
  });
}
