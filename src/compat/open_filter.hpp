// OpenFilter: a filter of NNStreamer's interface, of any version, with its model open.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "compat/properties.hpp"
#include "nnstreamer_plugin_api_filter.h"
#include "tensor_filter_custom.h"

namespace weir::compat {

class AsyncOutputs;

// Used by one thread at a time, except for destroy(). Outputs in use keep it open.
class OpenFilter : public std::enable_shared_from_this<OpenFilter> {
 public:
  explicit OpenFilter(std::unique_ptr<Properties> properties);
  virtual ~OpenFilter();
  OpenFilter(const OpenFilter&) = delete;
  OpenFilter& operator=(const OpenFilter&) = delete;

  Properties& properties() noexcept { return *properties_; }
  const std::string& name() const noexcept { return properties_->shown(); }  // for errors

  // Like the callbacks, the functions return a negative value on failure.
  struct Known {
    bool inputs, outputs;
  };
  virtual Known get_info(GstTensorsInfo* in, GstTensorsInfo* out) = 0;
  virtual int set_inputs(const GstTensorsInfo* in, GstTensorsInfo* out) = 0;
  virtual int invoke(const GstTensorMemory* in, GstTensorMemory* out) = 0;
  // Returns whether invoke() sets the outputs' `data`, which destroy() frees.
  virtual bool allocates() = 0;
  virtual void destroy(void* data) = 0;
  virtual int send(event_ops) { return -ENOENT; }

  std::unique_ptr<AsyncOutputs> async_outputs;  // for a model with asynchronous outputs

 protected:
  GstTensorFilterProperties* prop() noexcept { return properties_->get(); }
  // Returns the result of `function`; its exceptions become CALLBACK_FAILED.
  template <class Body>
  auto call(const char* function, Body&& body) {
    const auto threw = [&](const char* what) {
      return Failure(
          {.code = Code::CALLBACK_FAILED,
           .what = "the filter " + name() + " threw an exception in " + function,
           .offered = what,
           .needed = "a negative number on failure: exceptions must not cross C functions",
           .fix = "catch the exception in " + std::string(function) + " and return -EINVAL"});
    };
    try {
      return body();
    } catch (const Failure&) {
      throw;
    } catch (const std::exception& e) {
      throw threw(e.what());
    } catch (...) {
      throw threw("not a std::exception");
    }
  }

 private:
  std::unique_ptr<Properties> properties_;
};

// Returns for example "-22 (Invalid argument)".
inline std::string returned(int result) {
  std::string text = std::to_string(result);
  if (result < 0 && result > -200) text += std::string(" (") + std::strerror(-result) + ")";
  return text;
}

// Open a filter. Throw Failure when it does not open.
std::shared_ptr<OpenFilter> open_v0(const GstTensorFilterFramework& framework,
                                    std::unique_ptr<Properties> properties);
std::shared_ptr<OpenFilter> open_v1(const GstTensorFilterFramework& framework,
                                    std::unique_ptr<Properties> properties);
std::shared_ptr<OpenFilter> open_class(const NNStreamer_custom_class& callbacks,
                                       std::unique_ptr<Properties> properties);

// Makes the error that these functions throw when a callback returned a negative value.
inline Failure not_opened(const std::string& name, const std::string& offered) {
  return Failure({.code = Code::MODEL_INVALID,
                  .what = "the filter " + name + " cannot open its model",
                  .offered = offered,
                  .needed = "0 or above",
                  .fix = "set GST_DEBUG=weir*:5 to see the log messages of the filter"});
}

}  // namespace weir::compat
