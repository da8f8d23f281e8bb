// A library that registers filter objects when it is loaded: `negated` negates int8 3, and
// `counted` allocates as many values as its input has, each equal to its index.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>

#include "tensor_filter_cpp.hh"

namespace {

class Negated : public tensor_filter_cpp {
 public:
  Negated() : tensor_filter_cpp("negated") {}
  int getInputDim(GstTensorsInfo* info) override {
    info->num_tensors = 1;
    info->info[0].type = _NNS_INT8;
    info->info[0].dimension[0] = 3;
    return 0;
  }
  int getOutputDim(GstTensorsInfo* info) override { return getInputDim(info); }
  int setInputDim(const GstTensorsInfo*, GstTensorsInfo*) override { return -1; }
  int invoke(const GstTensorMemory* in, GstTensorMemory* out) override {
    for (int i = 0; i < 3; ++i)
      static_cast<signed char*>(out[0].data)[i] =
          static_cast<signed char>(-static_cast<const signed char*>(in[0].data)[i]);
    return 0;
  }
  bool isAllocatedBeforeInvoke() override { return true; }
};

class Counted : public tensor_filter_cpp {
 public:
  Counted() : tensor_filter_cpp("counted") {}
  int getInputDim(GstTensorsInfo*) override { return -1; }
  int getOutputDim(GstTensorsInfo*) override { return -1; }
  int setInputDim(const GstTensorsInfo* in, GstTensorsInfo* out) override {
    out->num_tensors = 1;
    out->info[0].type = _NNS_UINT8;
    out->info[0].dimension[0] = in->info[0].dimension[0];
    return 0;
  }
  int invoke(const GstTensorMemory*, GstTensorMemory* out) override {
    auto* y = static_cast<unsigned char*>(std::malloc(out[0].size));
    for (size_t i = 0; i < out[0].size; ++i) y[i] = static_cast<unsigned char>(i);
    out[0].data = y;
    return 0;
  }
  bool isAllocatedBeforeInvoke() override { return false; }
};

struct Registered {
  Registered() {
    negated._register();
    counted._register();
  }
  Negated negated;
  Counted counted;
} registered;

}  // namespace
