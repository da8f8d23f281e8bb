// A custom filter with one fault, chosen by its table (FAULT of the build) or by custom=.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <stdexcept>
#include <string>

#include "tensor_filter_custom.h"

namespace {

std::string fault;

void* begin(const GstTensorFilterProperties* prop) {
  fault = prop->custom_properties ? prop->custom_properties : "";
  if (fault == "throw-in-init") throw std::runtime_error("the device is gone");
  return nullptr;
}

void end(void*, const GstTensorFilterProperties*) {
  if (fault == "throw-in-exit") throw std::runtime_error("the device is gone");
}

void four(GstTensorsInfo* info) {
  info->num_tensors = 1;
  info->info[0].type = _NNS_FLOAT32;
  info->info[0].dimension[0] = 4;
}

int input(void*, const GstTensorFilterProperties*, GstTensorsInfo* info) {
  four(info);
  if (fault == "input-fails") return -5;
  if (fault == "throw-in-input") throw 7;
  return 0;
}

int output(void*, const GstTensorFilterProperties*, GstTensorsInfo* info) {
  auto& first = info->info[0];
  four(info);
  if (fault == "no-tensor") info->num_tensors = 0;
  if (fault == "257-tensors") info->num_tensors = 257;
  if (fault == "17-without-extra") {
    info->num_tensors = 17;
    for (auto& tensor : info->info) tensor = first;
  }
  if (fault == "no-dimension") first.dimension[0] = 0;
  if (fault == "hole") first.dimension[1] = 0, first.dimension[2] = 3;
  if (fault == "4-gib") first.dimension[0] = first.dimension[1] = 0x8000;
  if (fault == "overflow") first.dimension[0] = first.dimension[1] = first.dimension[2] = ~0u;
  if (fault == "type") first.type = static_cast<tensor_type>(11);
  if (fault == "negative-type") first.type = static_cast<tensor_type>(-1);
  return 0;
}

int set(void*, const GstTensorFilterProperties*, const GstTensorsInfo*, GstTensorsInfo* out) {
  return output(nullptr, nullptr, out);
}

int invoke(void*, const GstTensorFilterProperties*, const GstTensorMemory* in,
           GstTensorMemory* out) {
  if (fault == "throw-in-invoke") throw std::runtime_error("the device is gone");
  if (fault == "throw-a-number") throw 7;
  if (fault == "other-memory") {
    static float own[4];
    out[0].data = own;
    return 0;
  }
  if (fault == "smaller") out[0].size = 4;
  std::memcpy(out[0].data, in[0].data, 16);
  return 0;
}

NNStreamer_custom_class callbacks = [] {
  NNStreamer_custom_class all{};
  all.initfunc = begin;
  all.exitfunc = end;
  all.getInputDim = input;
  all.getOutputDim = output;
  all.invoke = invoke;
  switch (FAULT) {
    case 1:
      all.initfunc = nullptr;
      break;
    case 2:
      all.setInputDim = set;
      break;
    case 3:
      all.getOutputDim = nullptr;
      break;
    case 4:
      all.getInputDim = nullptr;
      all.getOutputDim = nullptr;
      break;
    case 5:
      all.allocate_invoke = invoke;
      break;
    case 6:
      all.invoke = nullptr;
      break;
  }
  return all;
}();

}  // namespace

extern "C" {
#if FAULT == 7
NNStreamer_custom_class* NNStreamer_custom = nullptr;
#else
NNStreamer_custom_class* NNStreamer_custom = &callbacks;
#endif
}

#if FAULT == 8
extern "C" int nnstreamer_no_such_function(void);
__attribute__((constructor)) static void calls() {
  nnstreamer_no_such_function();
}
#endif
