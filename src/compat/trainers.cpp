// Checks and lists trainers of sub-plugins. No element runs them yet.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/registration.hpp"
#include "nnstreamer_plugin_api_trainer.h"

using namespace weir::compat;
using weir::subplugin::Kind;

namespace {

// Returns null, with a log line, when the framework gives none.
const char* get_name(const char* function, const GstTensorTrainerFramework& framework) {
  GstTensorTrainerFrameworkInfo info{};
  if (framework.getFrameworkInfo(&framework, nullptr, nullptr, &info) >= 0 && info.name)
    return info.name;
  const weir::Error error{.code = weir::Code::MODULE_REFUSED,
                          .what = "the trainer's getFrameworkInfo returns no name",
                          .offered = info.name ? info.name : "NULL",
                          .needed = "a name, and a return value of 0 or above"};
  weir::subplugin::table().refuse(Kind::Trainer, error);
  warn(function, error);
  return nullptr;
}

bool has_version(const char* function, const GstTensorTrainerFramework& framework) {
  if (framework.version == GST_TENSOR_TRAINER_FRAMEWORK_V1) return true;
  char offered[32];
  g_snprintf(offered, sizeof offered, "0x%016" G_GINT64_MODIFIER "X", framework.version);
  const weir::Error error{.code = weir::Code::MODULE_REFUSED,
                          .what = "the trainer has an unsupported interface version",
                          .offered = offered,
                          .needed = "0xDEAFDEAD00010000"};
  weir::subplugin::table().refuse(Kind::Trainer, error);
  warn(function, error);
  return false;
}

}  // namespace

int nnstreamer_trainer_probe(GstTensorTrainerFramework* framework) {
  if (!given(__func__, {framework})) return FALSE;
  const char* function = __func__;
  return or_else(function, FALSE, [&]() -> int {
    if (!has_version(function, *framework)) return FALSE;
    const char* name =
        framework->getFrameworkInfo ? get_name(function, *framework) : "without getFrameworkInfo";
    if (!name) return FALSE;
    return register_descriptor(function, Kind::Trainer, name, framework,
                               {{"create", framework->create != nullptr},
                                {"destroy", framework->destroy != nullptr},
                                {"start", framework->start != nullptr},
                                {"stop", framework->stop != nullptr},
                                {"push_data", framework->push_data != nullptr},
                                {"getStatus", framework->getStatus != nullptr},
                                {"getFrameworkInfo", framework->getFrameworkInfo != nullptr}});
  });
}

int nnstreamer_trainer_exit(GstTensorTrainerFramework* framework) {
  if (!given(__func__, {framework})) return FALSE;
  return or_else(__func__, FALSE, [&]() -> int {
    for (const auto& name : weir::subplugin::table().names(Kind::Trainer))
      if (weir::subplugin::table().find(Kind::Trainer, name) == framework)
        return weir::subplugin::table().remove(Kind::Trainer, name);
    return FALSE;
  });
}

void nnstreamer_trainer_notify_event(GstTensorTrainerEventNotifier* notifier,
                                     GstTensorTrainerEventType event, void*) {
  if (!given(__func__, {notifier})) return;
  warn(__func__,
       "event " + std::to_string(event) + " is ignored, because no element runs trainers");
}
