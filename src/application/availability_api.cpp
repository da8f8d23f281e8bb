// ml_check_*: whether elements and engines are available.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include "capi-nnstreamer/nnstreamer.h"
#include "element_restriction.hpp"
#include "ml_error.hpp"
#include "nnfw.hpp"

namespace {

using namespace weir;
using namespace weir::application;

bool is_known(const char* factory) {
  if (!gst_init_check(nullptr, nullptr, nullptr)) return false;
  GstElementFactory* const found = gst_element_factory_find(factory);
  if (found) gst_object_unref(found);
  return found != nullptr;
}

}  // namespace

int ml_check_element_availability(const char* element_name, bool* available) {
  return guarded([&] {
    if (!element_name || !available) return fail(null_pointer("element_name or available"));
    *available = false;
    if (!is_known(element_name)) return static_cast<int>(ML_ERROR_NONE);
    const auto restriction = ElementRestriction::read();
    *available = restriction && restriction->check(element_name);
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_check_nnfw_availability_full(ml_nnfw_type_e nnfw, ml_nnfw_hw_e hw, const char* custom,
                                    bool* available) {
  return guarded([&] {
    if (!available) return fail(null_pointer("available"));
    *available = false;
    const auto framework = framework_name(nnfw);
    if (!framework) return fail(framework.error());
    if (nnfw == ML_NNFW_TYPE_ANY)
      return fail(Error{.code = Code::OPTION_VALUE,
                        .what = "nnfw names no framework",
                        .offered = "ML_NNFW_TYPE_ANY",
                        .needed = "a framework, such as ML_NNFW_TYPE_TENSORFLOW_LITE"});
    *available = static_cast<bool>(check_available(*framework, accelerator_name(hw), custom));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_check_nnfw_availability(ml_nnfw_type_e nnfw, ml_nnfw_hw_e hw, bool* available) {
  return ml_check_nnfw_availability_full(nnfw, hw, nullptr, available);
}
