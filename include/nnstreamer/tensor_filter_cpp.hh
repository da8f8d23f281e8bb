// A C++ object of the application as a filter: `tensor_filter framework=cpp model=NAME[,lib.so]`.
// Link with pkg-config nnstreamer-cpp. C++11.
//
// Derive from the class, create an object, register it. One object serves every element that names
// it, one call at a time. An exception becomes an error of the element. Signatures derived from the
// functions' names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef NNSTREAMER_TENSOR_FILTER_CPP_HH
#define NNSTREAMER_TENSOR_FILTER_CPP_HH
#include "nnstreamer_util.h"
#include "tensor_typedef.h"

class NNS_EXPORT tensor_filter_cpp {
 public:
  explicit tensor_filter_cpp(const char* modelName);
  virtual ~tensor_filter_cpp();  // releases the name if it is still registered
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

  // Returns 0; -EINVAL for an empty, reserved or taken name (with the reason in the log).
  int _register() { return __register(this); }
  static int __register(tensor_filter_cpp* filter);
  // Returns 0, or -EINVAL if it is not registered. No element may use it; the object may then be
  // destroyed.
  int _unregister() { return __unregister(name_); }
  static int __unregister(const char* modelName);

 private:
  char* name_;
};

#endif  // NNSTREAMER_TENSOR_FILTER_CPP_HH
