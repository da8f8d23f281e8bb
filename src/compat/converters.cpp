// Registers converters of sub-plugins and programs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/builtin.hpp"
#include "compat/registration.hpp"
#include "nnstreamer_plugin_api_converter.h"
#include "tensor_converter_custom.h"

using namespace weir::compat;
using weir::subplugin::Kind;

int registerExternalConverter(NNStreamerExternalConverter* ex) {
  if (!given(__func__, {ex})) return FALSE;
  return register_descriptor(__func__, Kind::Converter, ex->name, ex,
                             {{"name", ex->name != nullptr},
                              {"query_caps", ex->query_caps != nullptr},
                              {"get_out_config", ex->get_out_config != nullptr},
                              {"convert", ex->convert != nullptr}});
}

void unregisterExternalConverter(const char* name) {
  unregister_descriptor(__func__, Kind::Converter, name);
}

const NNStreamerExternalConverter* nnstreamer_converter_find(const char* name) {
  return find_descriptor(__func__, Kind::Converter, name, builtin_converter);
}

void nnstreamer_converter_set_custom_property_desc(const char* name, const char* key, ...) {
  va_list texts;
  va_start(texts, key);
  describe(__func__, Kind::Converter, name, key, texts);
  va_end(texts);
}

int nnstreamer_converter_custom_register(const char* name, tensor_converter_custom func,
                                         void* data) {
  return register_function(__func__, weir::subplugin::custom_converters(), name,
                           reinterpret_cast<weir::subplugin::AnyFunction>(func), data);
}

int nnstreamer_converter_custom_unregister(const char* name) {
  return unregister_function(__func__, weir::subplugin::custom_converters(), name);
}
