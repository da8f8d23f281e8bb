// Registers decoders of sub-plugins and programs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/builtin.hpp"
#include "compat/registration.hpp"
#include "nnstreamer_plugin_api_decoder.h"
#include "tensor_decoder_custom.h"

using namespace weir::compat;
using weir::subplugin::Kind;

int nnstreamer_decoder_probe(GstTensorDecoderDef* decoder) {
  if (!given(__func__, {decoder})) return FALSE;
  return register_descriptor(__func__, Kind::Decoder, decoder->modename, decoder,
                             {{"modename", decoder->modename != nullptr},
                              {"init", decoder->init != nullptr},
                              {"getOutCaps", decoder->getOutCaps != nullptr},
                              {"decode", decoder->decode != nullptr}});
}

void nnstreamer_decoder_exit(const char* name) {
  unregister_descriptor(__func__, Kind::Decoder, name);
}

const GstTensorDecoderDef* nnstreamer_decoder_find(const char* name) {
  return find_descriptor(__func__, Kind::Decoder, name, builtin_decoder);
}

void nnstreamer_decoder_set_custom_property_desc(const char* name, const char* key, ...) {
  va_list texts;
  va_start(texts, key);
  describe(__func__, Kind::Decoder, name, key, texts);
  va_end(texts);
}

int nnstreamer_decoder_custom_register(const char* name, tensor_decoder_custom func, void* data) {
  return register_function(__func__, weir::subplugin::custom_decoders(), name,
                           reinterpret_cast<weir::subplugin::AnyFunction>(func), data);
}

int nnstreamer_decoder_custom_unregister(const char* name) {
  return unregister_function(__func__, weir::subplugin::custom_decoders(), name);
}
