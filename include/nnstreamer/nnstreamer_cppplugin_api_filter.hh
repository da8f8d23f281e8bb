// Filter sub-plugins as a C++ class: derive from nnstreamer::tensor_filter_subplugin and call
// register_subplugin<YourClass>() in a constructor of the library. C++11. A header-only wrapper of
// version 1 of the C interface; link with pkg-config nnstreamer-cpp.
//
// Exceptions become return values and their text is logged: std::system_error its negated code,
// std::bad_alloc -ENOMEM, std::invalid_argument, std::runtime_error and any other -EINVAL.
// Signatures derived.
// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef NNSTREAMER_CPPPLUGIN_API_FILTER_HH
#define NNSTREAMER_CPPPLUGIN_API_FILTER_HH
#include <errno.h>

#include <cstdlib>
#include <exception>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include "nnstreamer_plugin_api_filter.h"

namespace nnstreamer {

class tensor_filter_subplugin {
 public:
  virtual ~tensor_filter_subplugin() {}

  // Returns a new object of the same class, without a model.
  virtual tensor_filter_subplugin& getEmptyInstance() = 0;
  // Opens the model that the properties name. Throws on failure.
  virtual void configure_instance(const GstTensorFilterProperties* prop) = 0;
  virtual void invoke(const GstTensorMemory* input, GstTensorMemory* output) = 0;
  // For invoke-dynamic=true: sets output_meta of `prop` and allocates the outputs with g_malloc().
  virtual void invoke_dynamic(GstTensorFilterProperties* prop, const GstTensorMemory* input,
                              GstTensorMemory* output) {
    (void)prop;
    (void)input;
    (void)output;
    throw std::runtime_error("this filter has no invoke_dynamic");
  }
  // Describes the framework; also called on an object without a model.
  virtual void getFrameworkInfo(GstTensorFilterFrameworkInfo& info) = 0;
  // Returns 0, or -ENOENT if unsupported.
  virtual int getModelInfo(model_info_ops op, GstTensorsInfo& in_info,
                           GstTensorsInfo& out_info) = 0;
  // Returns 0, or -ENOENT for an unknown event.
  virtual int eventHandler(event_ops op, GstTensorFilterFrameworkEventData& data) {
    (void)op;
    (void)data;
    return -ENOENT;
  }

  // Registers the class. Returns the object that represents it, for unregister_subplugin(), or NULL
  // on failure, with the reason in the log.
  template <typename T>
  static T* register_subplugin();
  template <typename T>
  static void unregister_subplugin(T* representation);

 private:
  template <typename Body>
  static int guard(Body body);
  static int open(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                  void** priv);

  template <typename T>
  static GstTensorFilterFramework& table();
};

// Returns the value of `body`, or a negative number for its exception.
template <typename Body>
int tensor_filter_subplugin::guard(Body body) {
  try {
    return body();
  } catch (const std::system_error& e) {
    nns_loge("%s", e.what());
    const int code = std::abs(e.code().value());
    return code ? -code : -EINVAL;
  } catch (const std::bad_alloc&) {
    return -ENOMEM;
  } catch (const std::exception& e) {
    nns_loge("%s", e.what());
  } catch (...) {
    nns_loge("an exception of an unknown type");
  }
  return -EINVAL;
}

inline int tensor_filter_subplugin::open(const GstTensorFilterFramework* self,
                                         const GstTensorFilterProperties* prop, void** priv) {
  return guard([&]() -> int {
    auto* empty = static_cast<tensor_filter_subplugin*>(self->subplugin_data);
    std::unique_ptr<tensor_filter_subplugin> made(&empty->getEmptyInstance());
    made->configure_instance(prop);
    *priv = made.release();
    return 0;
  });
}

// One descriptor per class.
template <typename T>
GstTensorFilterFramework& tensor_filter_subplugin::table() {
  static GstTensorFilterFramework table;
  return table;
}

template <typename T>
T* tensor_filter_subplugin::register_subplugin() {
  typedef tensor_filter_subplugin Base;
  GstTensorFilterFramework& made = table<T>();
  if (made.subplugin_data) return static_cast<T*>(static_cast<Base*>(made.subplugin_data));
  made.version = GST_TENSOR_FILTER_FRAMEWORK_V1;
  made.open = [](const GstTensorFilterProperties* prop, void** priv) -> int {
    return Base::open(&table<T>(), prop, priv);
  };
  made.close = [](const GstTensorFilterProperties*, void** priv) {
    guard([&]() -> int {
      delete static_cast<Base*>(*priv);
      *priv = NULL;
      return 0;
    });
  };
  made.invoke = [](const GstTensorFilterFramework*, GstTensorFilterProperties* prop, void* priv,
                   const GstTensorMemory* input, GstTensorMemory* output) -> int {
    return guard([&]() -> int {
      auto* object = static_cast<Base*>(priv);
      if (!object || !input || !output) return -EINVAL;
      if (prop && prop->invoke_dynamic)
        object->invoke_dynamic(prop, input, output);
      else
        object->invoke(input, output);
      return 0;
    });
  };
  made.getFrameworkInfo = [](const GstTensorFilterFramework* self, const GstTensorFilterProperties*,
                             void* priv, GstTensorFilterFrameworkInfo* info) -> int {
    return guard([&]() -> int {
      static_cast<Base*>(priv ? priv : self->subplugin_data)->getFrameworkInfo(*info);
      return 0;
    });
  };
  made.getModelInfo = [](const GstTensorFilterFramework*, const GstTensorFilterProperties*,
                         void* priv, model_info_ops op, GstTensorsInfo* in_info,
                         GstTensorsInfo* out_info) -> int {
    if (!priv || !in_info || !out_info) return -EINVAL;
    return guard(
        [&]() -> int { return static_cast<Base*>(priv)->getModelInfo(op, *in_info, *out_info); });
  };
  made.eventHandler = [](const GstTensorFilterFramework* self, const GstTensorFilterProperties*,
                         void* priv, event_ops op, GstTensorFilterFrameworkEventData* data) -> int {
    if ((!priv && !self) || !data) return -EINVAL;
    return guard([&]() -> int {
      return static_cast<Base*>(priv ? priv : self->subplugin_data)->eventHandler(op, *data);
    });
  };
  std::unique_ptr<T> representation;
  if (guard([&]() -> int {
        representation.reset(new T());
        return 0;
      }) < 0)
    return NULL;
  made.subplugin_data = static_cast<Base*>(representation.get());
  if (!nnstreamer_filter_probe(&made)) {
    made.subplugin_data = NULL;
    return NULL;
  }
  return representation.release();
}

template <typename T>
void tensor_filter_subplugin::unregister_subplugin(T* representation) {
  GstTensorFilterFramework& made = table<T>();
  if (!representation || !made.subplugin_data) return;
  GstTensorFilterFrameworkInfo info = GstTensorFilterFrameworkInfo();
  if (guard([&]() -> int {
        representation->getFrameworkInfo(info);
        return 0;
      }) == 0 &&
      info.name)
    nnstreamer_filter_exit(info.name);
  made.subplugin_data = NULL;
  delete representation;
}

}  // namespace nnstreamer

#endif  // NNSTREAMER_CPPPLUGIN_API_FILTER_HH
