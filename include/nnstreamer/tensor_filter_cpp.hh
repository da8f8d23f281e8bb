// An object of a C++ program as a filter: `tensor_filter framework=cpp model=NAME[,lib.so]`. Link
// with pkg-config nnstreamer-cpp. C++11.
//
// Derive from the class, make an object, register it. One object serves every element that names
// it, one call at a time. What a function throws ends as an error of the element. Signatures
// derived from the functions' names.
#ifndef NNSTREAMER_TENSOR_FILTER_CPP_HH
#define NNSTREAMER_TENSOR_FILTER_CPP_HH
#include "nnstreamer_util.h"
#include "tensor_typedef.h"

class NNS_EXPORT tensor_filter_cpp {
 public:
  explicit tensor_filter_cpp(const char* modelName);
  virtual ~tensor_filter_cpp();  // frees the name where it is still registered
  tensor_filter_cpp(const tensor_filter_cpp&) = delete;
  tensor_filter_cpp& operator=(const tensor_filter_cpp&) = delete;

  // 0 or more when filled, below 0 where the filter takes what comes (then setInputDim says what it
  // gives).
  virtual int getInputDim(GstTensorsInfo* info) = 0;
  virtual int getOutputDim(GstTensorsInfo* info) = 0;
  // Says the outputs for inputs of these; below 0 where they are fixed, or not taken.
  virtual int setInputDim(const GstTensorsInfo* in, GstTensorsInfo* out) = 0;
  // 0; below 0 = failed, above 0 = nothing comes of this frame.
  virtual int invoke(const GstTensorMemory* in, GstTensorMemory* out) = 0;
  // True: invoke writes into memory that is there. False: it sets `data` of each output to memory
  // of malloc(), which Weir frees.
  virtual bool isAllocatedBeforeInvoke() = 0;

  const char* getName() const { return name_; }

  // 0; -EINVAL for a name that is empty, reserved or taken (the words are in the log).
  int _register() { return __register(this); }
  static int __register(tensor_filter_cpp* filter);
  // 0, or -EINVAL when it is not registered. No element may have it: the object can go then.
  int _unregister() { return __unregister(name_); }
  static int __unregister(const char* modelName);

 private:
  char* name_;
};

#endif  // NNSTREAMER_TENSOR_FILTER_CPP_HH
