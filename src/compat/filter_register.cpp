// nnstreamer_filter_probe() and related functions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/builtin.hpp"
#include "compat/framework_check.hpp"
#include "compat/registration.hpp"
#include "nnstreamer_plugin_api_filter.h"

using namespace weir::compat;
using weir::subplugin::Kind;

int nnstreamer_filter_probe(GstTensorFilterFramework* framework) {
  if (!given(__func__, {framework})) return FALSE;
  return or_else(__func__, FALSE, [&]() -> int {
    const auto facts = read_facts(*framework);
    if (!facts) weir::subplugin::table().refuse(Kind::Filter, facts.error());
    const auto status = facts ? weir::subplugin::table().add(Kind::Filter, facts->name, framework)
                              : weir::Status(facts.error());
    if (status) return TRUE;
    warn("nnstreamer_filter_probe", status.error());
    return FALSE;
  });
}

void nnstreamer_filter_exit(const char* name) {
  unregister_descriptor(__func__, Kind::Filter, name);
}

const GstTensorFilterFramework* nnstreamer_filter_find(const char* name) {
  return find_descriptor(__func__, Kind::Filter, name, builtin_filter);
}

void nnstreamer_filter_set_custom_property_desc(const char* name, const char* key, ...) {
  va_list texts;
  va_start(texts, key);
  describe(__func__, Kind::Filter, name, key, texts);
  va_end(texts);
}

void nnstreamer_filter_dispatch_output_async(GstTensorFilterProperties* prop,
                                             GstTensorMemory* output) {
  if (!given(__func__, {prop, output})) return;
  if (prop->async_callback)
    prop->async_callback(output, &prop->output_meta, prop->async_user_data);
  else
    warn(__func__, "the output is dropped, because the element does not have invoke-async=true");
}
