// A C++ object of the application as a filter: `tensor_filter framework=cpp model=NAME[,lib.so]`.
// Link with pkg-config nnstreamer-cpp. C++11.
//
// Derive from the class, create an object, register it. One object serves every element that names
// it, one call at a time. An exception becomes an error of the element. Signatures derived from the
// functions' names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef NNSTREAMER_TENSOR_FILTER_CPP_HH
#define NNSTREAMER_TENSOR_FILTER_CPP_HH
#include <atomic>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "nnstreamer_plugin_api_filter.h"
#include "nnstreamer_util.h"
#include "tensor_typedef.h"

class NNS_EXPORT tensor_filter_cpp {
 public:
  explicit tensor_filter_cpp(const char* modelName);
  // Releases the name if it is still registered. Elements that use the object fail at their next
  // frame; none may be in one of its functions.
  virtual ~tensor_filter_cpp();
  tensor_filter_cpp(const tensor_filter_cpp&) = delete;
  tensor_filter_cpp& operator=(const tensor_filter_cpp&) = delete;

  // Returns 0 or more with `info` filled, or below 0 if the filter adapts to the input (setInputDim
  // then computes the output).
  virtual int getInputDim(GstTensorsInfo* info) = 0;
  virtual int getOutputDim(GstTensorsInfo* info) = 0;
  // Computes the outputs for these inputs; below 0 if they are fixed or rejected.
  virtual int setInputDim(const GstTensorsInfo* in, GstTensorsInfo* out) = 0;
  // Returns 0; below 0 on failure, above 0 to drop the frame.
  virtual int invoke(const GstTensorMemory* in, GstTensorMemory* out) = 0;
  // True: invoke writes into memory provided by Weir. False: invoke sets `data` of each output to
  // memory from malloc(), which Weir frees.
  virtual bool isAllocatedBeforeInvoke() = 0;

  const char* getName() const { return name_; }
  bool isValid() { return valid_ == kValid; }  // false: no object, or one that was destroyed

  // Returns 0; -EINVAL for an empty, reserved or taken name (with the reason in the log).
  // `ref_count`: users that it already has.
  int _register(unsigned int ref_count = 0) { return __register(this, ref_count); }
  static int __register(tensor_filter_cpp* filter, unsigned int ref_count = 0);
  // Returns 0, or -EINVAL if it is not registered. An element that uses it is logged and fails at
  // its next start; the object may be destroyed when no element uses it.
  int _unregister() { return __unregister(name_); }
  static int __unregister(const char* modelName);

  // The layout is that of libraries which were built against NNStreamer.
 private:
  friend struct weir_filter_object;
  static constexpr uint32_t kValid = 0xDEAFDEAD;
  uint32_t valid_ = kValid;
  char* name_;
  std::atomic<unsigned int> users_;

 protected:
  // Of the element that opened the filter last: custom_properties has the user's options. NULL
  // while none has opened it.
  const GstTensorFilterProperties* prop = nullptr;
};

#endif  // NNSTREAMER_TENSOR_FILTER_CPP_HH
