// GTensorFilterSingle: a model without a pipeline, as a GObject.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <glib-object.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "compat/builtin_engine.hpp"
#include "compat/guard.hpp"
#include "compat/tensors.hpp"
#include "core/infer/model/invoke_statistics.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/property_file.hpp"
#include "gstcpp/element/ref.hpp"
#include "nnstreamer_plugin_api_util.h"
#include "tensor_filter_single.h"
#include "weir/join.hpp"

namespace weir::compat {
namespace {

enum class SingleValue { Text, ReadOnlyText, Switch, Number, Duration };
struct SingleProperty {
  const char* name;
  SingleValue value;
};
// Those of tensor_filter. The number of a property is its place here, from 1.
constexpr std::array kSingleProperties{
    SingleProperty{"framework", SingleValue::Text},
    SingleProperty{"model", SingleValue::Text},
    SingleProperty{"input", SingleValue::Text},
    SingleProperty{"inputtype", SingleValue::Text},
    SingleProperty{"inputname", SingleValue::Text},
    SingleProperty{"inputlayout", SingleValue::Text},
    SingleProperty{"inputranks", SingleValue::ReadOnlyText},
    SingleProperty{"output", SingleValue::Text},
    SingleProperty{"outputtype", SingleValue::Text},
    SingleProperty{"outputname", SingleValue::Text},
    SingleProperty{"outputlayout", SingleValue::Text},
    SingleProperty{"outputranks", SingleValue::ReadOnlyText},
    SingleProperty{"custom", SingleValue::Text},
    SingleProperty{"sub-plugins", SingleValue::ReadOnlyText},
    SingleProperty{"accelerator", SingleValue::Text},
    SingleProperty{"is-updatable", SingleValue::Switch},
    SingleProperty{"latency", SingleValue::Number},
    SingleProperty{"throughput", SingleValue::Number},
    SingleProperty{"input-combination", SingleValue::Text},
    SingleProperty{"output-combination", SingleValue::Text},
    SingleProperty{"shared-tensor-filter-key", SingleValue::Text},
    SingleProperty{"latency-report", SingleValue::Switch},
    SingleProperty{"invoke-dynamic", SingleValue::Switch},
    SingleProperty{"invoke-async", SingleValue::Switch},
    SingleProperty{"config-file", SingleValue::Text},
    SingleProperty{"suspend", SingleValue::Duration},
    SingleProperty{"silent", SingleValue::Switch},
};

// The properties as the user set them, and the model while it is open.
class SingleFilter {
 public:
  void set(const SingleProperty& property, const GValue* value) {
    if (property.value == SingleValue::Switch)
      numbers_[property.name] = g_value_get_boolean(value);
    else if (property.value == SingleValue::Number)
      numbers_[property.name] = g_value_get_int(value);
    else if (property.value == SingleValue::Duration)
      numbers_[property.name] = g_value_get_uint(value);
    else
      texts_[property.name] = or_empty(g_value_get_string(value));
  }
  void get(const SingleProperty& property, GValue* value) {
    const std::string name = property.name;
    if (property.value == SingleValue::Switch)
      g_value_set_boolean(value, number(name) != 0);
    else if (name == "latency")
      g_value_set_int(value, number(name) ? statistics_.latency_us() : -1);
    else if (name == "throughput")
      g_value_set_int(value, number(name) ? statistics_.throughput_milli() : -1);
    else if (property.value == SingleValue::Duration)
      g_value_set_uint(value, static_cast<guint>(number(name)));
    else
      g_value_set_string(value, text(name).c_str());
  }

  bool start() {
    if (model_) return true;
    if (!text_of("input-combination").empty() || (number("invoke-async") && !callback_)) {
      warn("start", "invoke-async needs a callback, and input-combination is not supported");
      return false;
    }
    std::vector<std::string> paths;
    const std::string models = text_of("model");
    for (const auto path : split(models, ","))
      if (!strip(path).empty()) paths.emplace_back(strip(path));
    const auto engine = direct::engine_for(text_of("framework"), paths);
    if (!engine) return warn("start", engine.error()), false;
    model_ = open(**engine, paths);
    return model_ && load_tensors();
  }
  void stop() { model_.reset(); }
  bool has_inputs() const { return model_ && (*in_).num_tensors > 0; }
  bool has_outputs() const { return model_ && (*out_).num_tensors > 0; }

  int set_inputs(const GstTensorsInfo& in, GstTensorsInfo* out) {
    if (!model_) return -EINVAL;
    const bool resizes = std::string_view(model_->model().engine().name) == "tensorflow-lite";
    GstTensorsInfo made;
    const int result = resizes ? model_->resize_inputs(in, &made) : model_->set_inputs(in, &made);
    if (result < 0) return resizes || result != -EINVAL ? result : -ENOENT;
    gst_tensors_info_free(&made);
    if (!load_tensors()) return -ENOENT;
    gst_tensors_info_copy(out, out_.get());
    for (const char* role : {"input", "output"})
      for (const char* part : {"", "type"}) texts_.erase(std::string(role) + part);
    return 0;
  }

  bool allocates() const {
    return model_ && (model_->model().info().flags & WEIR_MODEL_ALLOCATES_OUTPUT) != 0;
  }
  void destroy(GstTensorMemory* output) const {
    for (size_t i = 0; i < (*out_).num_tensors; ++i) g_free(std::exchange(output[i].data, nullptr));
  }

  bool invoke(const GstTensorMemory* input, GstTensorMemory* output, bool allocate) {
    if (!start()) return false;
    if (number("invoke-async")) return invoke_for_callback(input);
    if (!allocate) return run(input, output) == 0;
    for (size_t i = 0; i < (*out_).num_tensors; ++i) {
      if (output[i].size == 0 || output[i].size != output_size(i)) return false;
      output[i].data = nullptr;  // run() allocates it
    }
    if (run(input, output) == 0) return true;
    destroy(output);
    return false;
  }
  void set_callback(GstTensorDataCallback callback, void* user) {
    callback_ = callback;
    user_ = user;
  }

 private:
  std::unique_ptr<BuiltinModel> open(const weir_engine& engine,
                                     const std::vector<std::string>& paths) {
    std::vector<const char*> files;
    files.reserve(paths.size());
    for (const auto& path : paths) files.push_back(path.c_str());
    GstTensorFilterProperties prop{};
    OwnedTensorsInfo in, out;
    declare("input", in.get());
    declare("output", out.get());
    prop.fwname = engine.name;
    prop.model_files = files.data();
    prop.num_models = static_cast<int>(files.size());
    prop.input_meta = *in.get();
    prop.output_meta = *out.get();
    const std::string custom = text_of("custom"), accelerator = text_of("accelerator");
    prop.custom_properties = custom.c_str();
    prop.accl_str = accelerator.c_str();
    prop.invoke_dynamic = static_cast<int>(number("invoke-dynamic"));
    return BuiltinModel::open(engine, prop);
  }
  // Reads the properties of the user, such as input, inputtype and inputname.
  void declare(const std::string& role, GstTensorsInfo* info) {
    const std::string shapes = text_of(role);
    info->num_tensors = gst_tensors_info_parse_dimensions_string(info, shapes.c_str());
    gst_tensors_info_parse_types_string(info, text_of(role + "type").c_str());
    gst_tensors_info_parse_names_string(info, text_of(role + "name").c_str());
  }
  bool load_tensors() {
    gst_tensors_info_free(in_.get());
    gst_tensors_info_free(out_.get());
    return model_->get_inputs(in_.get()) == 0 && model_->get_outputs(out_.get()) == 0;
  }
  size_t output_size(size_t index) {
    return gst_tensor_info_get_size(gst_tensors_info_get_nth_info(out_.get(), index));
  }

  int run(const GstTensorMemory* input, GstTensorMemory* output) {
    GstTensorFilterProperties prop{};
    prop.input_meta = *in_.get();
    const auto begin = std::chrono::steady_clock::now();
    const int result = model_->invoke(&prop, input, output);
    if (result == 0) statistics_.record(std::chrono::steady_clock::now() - begin);
    return result;
  }
  bool invoke_for_callback(const GstTensorMemory* input) {
    std::vector<GstTensorMemory> outputs((*out_).num_tensors);
    const bool done = run(input, outputs.data()) == 0;
    if (done) callback_(outputs.data(), out_.get(), user_);
    destroy(outputs.data());
    return done;
  }

  int64_t number(const std::string& name) const {
    const auto found = numbers_.find(name);
    return found == numbers_.end() ? name == "silent" : found->second;
  }
  std::string text_of(const std::string& name) const {
    const auto found = texts_.find(name);
    return found == texts_.end() ? "" : found->second;
  }
  // The text of the user, otherwise what the open model says.
  std::string text(const std::string& name) {
    if (name == "sub-plugins") return join(infer::ModuleLibrary::instance().engine_names(), ",");
    const bool is_input = name.starts_with("input");
    const std::string part =
        name.substr(std::min(name.size(), std::strlen(is_input ? "input" : "output")));
    const bool is_of_tensors = (is_input || name.starts_with("output")) && !part.starts_with("-");
    if (!is_of_tensors || !text_of(name).empty()) return text_of(name);
    if (!model_) return "";
    const GstTensorsInfo& info = is_input ? *in_ : *out_;
    if (part == "type") return taken(gst_tensors_info_get_types_string(&info));
    if (part == "name") return taken(gst_tensors_info_get_names_string(&info));
    if (part.empty()) return taken(gst_tensors_info_get_dimensions_string(&info));
    std::vector<std::string> parts;
    for (unsigned i = 0; i < info.num_tensors; ++i)
      parts.push_back(
          part == "layout" ? "ANY" : std::to_string(gst_tensor_info_get_rank(tensor_at(info, i))));
    return join(parts, ",");
  }
  static std::string taken(gchar* text) {
    const gst::UniqueText owned(text);
    return or_empty(text);
  }

  std::map<std::string, std::string> texts_;
  std::map<std::string, int64_t> numbers_;
  std::unique_ptr<BuiltinModel> model_;
  OwnedTensorsInfo in_, out_;  // of the model
  GstTensorDataCallback callback_ = nullptr;
  void* user_ = nullptr;
  infer::InvokeStatistics statistics_;
};

SingleFilter* filter_in(gpointer self) {
  return static_cast<SingleFilter*>(static_cast<GTensorFilterSingle*>(self)->priv);
}

gboolean single_invoke(GTensorFilterSingle* self, const GstTensorMemory* input,
                       GstTensorMemory* output, gboolean allocate) {
  if (!given("invoke", {self, input, output})) return FALSE;
  return or_else("invoke", FALSE, [&]() -> gboolean {
    return filter_in(self)->invoke(input, output, allocate != FALSE);
  });
}

gint single_set_input_info(GTensorFilterSingle* self, const GstTensorsInfo* in,
                           GstTensorsInfo* out) {
  if (!given("set_input_info", {self, in, out})) return -EINVAL;
  return or_else("set_input_info", -EINVAL, [&] { return filter_in(self)->set_inputs(*in, out); });
}

void set_single_property(GObject* self, guint id, const GValue* value, GParamSpec*) {
  attempt("set_property", [&] {
    const auto& property = kSingleProperties[id - 1];
    filter_in(self)->set(property, value);
    const char* path =
        std::strcmp(property.name, "config-file") == 0 ? g_value_get_string(value) : nullptr;
    if (path && *path)
      if (auto status = gst::set_properties_from_file(self, path); !status)
        warn("config-file", status.error());
  });
}

void get_single_property(GObject* self, guint id, GValue* value, GParamSpec*) {
  attempt("get_property", [&] { filter_in(self)->get(kSingleProperties[id - 1], value); });
}

GParamSpec* make_spec(const SingleProperty& property) {
  const char *name = property.name, *about = "As the property of tensor_filter";
  const auto both = GParamFlags(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS);
  const auto read = GParamFlags(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS);
  switch (property.value) {
    case SingleValue::Switch:
      return g_param_spec_boolean(name, name, about, std::strcmp(name, "silent") == 0, both);
    case SingleValue::Number:
      return g_param_spec_int(name, name, about, 0, 1, 0, both);
    case SingleValue::Duration:
      return g_param_spec_uint(name, name, about, 0, G_MAXUINT, 0, both);
    default:
      return g_param_spec_string(name, name, about, nullptr,
                                 property.value == SingleValue::Text ? both : read);
  }
}

void init_single_class(gpointer pointer, gpointer) {
  auto* klass = static_cast<GTensorFilterSingleClass*>(pointer);
  klass->parent.set_property = set_single_property;
  klass->parent.get_property = get_single_property;
  klass->parent.finalize = [](GObject* self) {
    delete filter_in(self);
    G_OBJECT_CLASS(g_type_class_peek(G_TYPE_OBJECT))->finalize(self);
  };
  for (guint i = 0; i < kSingleProperties.size(); ++i)
    g_object_class_install_property(&klass->parent, i + 1, make_spec(kSingleProperties[i]));
  klass->invoke = single_invoke;
  klass->start = [](GTensorFilterSingle* self) -> gboolean {
    return given("start", {self}) &&
           or_else("start", false, [&] { return filter_in(self)->start(); });
  };
  klass->stop = [](GTensorFilterSingle* self) -> gboolean {
    if (self) filter_in(self)->stop();
    return self != nullptr;
  };
  klass->input_configured = [](GTensorFilterSingle* self) -> gboolean {
    return given("input_configured", {self}) && filter_in(self)->has_inputs();
  };
  klass->output_configured = [](GTensorFilterSingle* self) -> gboolean {
    return given("output_configured", {self}) && filter_in(self)->has_outputs();
  };
  klass->set_input_info = single_set_input_info;
  klass->allocate_in_invoke = [](GTensorFilterSingle* self) -> gboolean {
    return given("allocate_in_invoke", {self}) && filter_in(self)->allocates();
  };
  klass->destroy_notify = [](GTensorFilterSingle* self, GstTensorMemory* output) {
    if (given("destroy_notify", {self, output})) filter_in(self)->destroy(output);
  };
  klass->set_invoke_async_callback = [](GTensorFilterSingle* self, GstTensorDataCallback callback,
                                        void* user) -> gboolean {
    if (!given("set_invoke_async_callback", {self}) || !callback) return FALSE;
    filter_in(self)->set_callback(callback, user);
    return TRUE;
  };
}

void init_single(GTypeInstance* instance, gpointer) {
  reinterpret_cast<GTensorFilterSingle*>(instance)->priv = new SingleFilter;
}

}  // namespace
}  // namespace weir::compat

GType g_tensor_filter_single_get_type() {
  static const GType type = g_type_register_static_simple(
      G_TYPE_OBJECT, "GTensorFilterSingle", sizeof(GTensorFilterSingleClass),
      weir::compat::init_single_class, sizeof(GTensorFilterSingle), weir::compat::init_single,
      GTypeFlags(0));
  return type;
}
