// Whether a framework supports an accelerator: queries sub-plugins.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "compat/framework_check.hpp"
#include "compat/guard.hpp"
#include "compat/properties.hpp"
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

}  // namespace

bool weir::compat::has_hardware(const void* descriptor, unsigned hardware, const char* custom) {
  return or_else(__func__, false, [&] {
    return has(*static_cast<const GstTensorFilterFramework*>(descriptor),
               static_cast<accl_hw>(hardware), custom);
  });
}

gboolean gst_tensor_filter_check_hw_availability(const gchar* name, const accl_hw hw,
                                                 const gchar* custom) {
  if (!given(__func__, {name}) || hw == ACCL_NONE) return FALSE;
  return or_else(__func__, FALSE, [&]() -> gboolean {
    const auto status = weir::subplugin::check_available(name, hw, custom);
    if (!status && status.error().code != weir::Code::OPTION_VALUE) warn(__func__, status.error());
    return status ? TRUE : FALSE;
  });
}
