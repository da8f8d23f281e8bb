// nnstreamer_filter_probe() and what belongs to it.
#include <cstdarg>

#include "compat/framework_check.hpp"
#include "compat/guard.hpp"
#include "core/subplugin/loader.hpp"
#include "core/subplugin/table.hpp"
#include "nnstreamer_plugin_api_filter.h"

using namespace weir::compat;
using weir::subplugin::Kind;

int nnstreamer_filter_probe(GstTensorFilterFramework* framework) {
  if (!given(__func__, {framework})) return FALSE;
  return or_else(__func__, FALSE, [&]() -> int {
    const auto facts = facts_of(*framework);
    if (!facts) weir::subplugin::table().refuse(Kind::Filter, facts.error());
    const auto status = facts ? weir::subplugin::table().add(Kind::Filter, facts->name, framework)
                              : weir::Status(facts.error());
    if (status) return TRUE;
    warn("nnstreamer_filter_probe", status.error());
    return FALSE;
  });
}

void nnstreamer_filter_exit(const char* name) {
  if (!given(__func__, {name})) return;
  attempt(__func__, [&] {
    if (!weir::subplugin::table().remove(Kind::Filter, name))
      warn("nnstreamer_filter_exit", std::string("no filter has the name ") + name);
  });
}

const GstTensorFilterFramework* nnstreamer_filter_find(const char* name) {
  using Framework = const GstTensorFilterFramework*;
  if (!given(__func__, {name})) return nullptr;
  return or_else<Framework>(__func__, nullptr, [&]() -> Framework {
    const auto found = weir::subplugin::open(Kind::Filter, name);
    if (!found) warn("nnstreamer_filter_find", found.error());
    return found ? static_cast<Framework>(*found) : nullptr;
  });
}

void nnstreamer_filter_set_custom_property_desc(const char* name, const char* key, ...) {
  if (!given(__func__, {name})) return;
  va_list pairs;
  va_start(pairs, key);
  attempt(__func__, [&] {
    for (; key; key = va_arg(pairs, const char*)) {
      const char* text = va_arg(pairs, const char*);
      if (!text) break;
      weir::subplugin::table().describe(Kind::Filter, name, key, text);
    }
  });
  va_end(pairs);
}

void nnstreamer_filter_dispatch_output_async(GstTensorFilterProperties* prop,
                                             GstTensorMemory* output) {
  if (!given(__func__, {prop, output})) return;
  if (prop->async_callback)
    prop->async_callback(output, prop->async_user_data);
  else
    warn(__func__, "the element has not invoke-async=true: the output is dropped");
}
