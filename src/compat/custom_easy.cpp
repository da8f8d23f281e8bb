// NNS_custom_easy_*: a program's functions as filters, on weir/custom_filter.h.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cerrno>
#include <memory>

#include "compat/filter_model.hpp"
#include "compat/registration.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/named_objects.hpp"
#include "core/infer/queue/call_gate.hpp"
#include "nnstreamer_plugin_api_util.h"
#include "tensor_filter_custom_easy.h"
#include "weir/custom_filter.h"

using namespace weir::compat;

namespace {

constexpr unsigned kMaxTensors = NNS_TENSOR_SIZE_LIMIT;

using Gate = std::shared_ptr<weir::infer::CallGate>;

// Returns the gates by filter name.
weir::infer::NamedObjects<Gate>& gates() {
  static auto& all = *new weir::infer::NamedObjects<Gate>;
  return all;
}

class EasyFunction final : public OpenFilter {
 public:
  NNS_custom_invoke fixed = nullptr;
  NNS_custom_invoke_dynamic dynamic = nullptr;
  void* data = nullptr;
  // Elements keep the filter; the gate closes when the program unregisters its function and data.
  const Gate gate = std::make_shared<weir::infer::CallGate>();

  EasyFunction(std::unique_ptr<Properties> properties, const GstTensorsInfo& in,
               const GstTensorsInfo* out)
      : OpenFilter(std::move(properties)) {
    gst_tensors_info_copy(&in_, &in);
    gst_tensors_info_init(&out_);
    if (out) gst_tensors_info_copy(&out_, out);
  }
  ~EasyFunction() override {
    gst_tensors_info_free(&in_);
    gst_tensors_info_free(&out_);
  }

  Known get_info(GstTensorsInfo* in, GstTensorsInfo* out) override {
    copy(in_, in);
    copy(out_, out);
    return {true, fixed && out_.format == _NNS_TENSOR_FORMAT_STATIC};
  }
  // Flexible outputs have a number but no dimensions: they get those of the inputs. A function that
  // chooses the sizes itself is registered as dynamic.
  int set_inputs(const GstTensorsInfo* in, GstTensorsInfo* out) override {
    if (out_.format == _NNS_TENSOR_FORMAT_STATIC) return -ENOENT;
    if (out_.num_tensors > in->num_tensors) return -EINVAL;
    copy(*in, out);
    out->num_tensors = out_.num_tensors;
    return 0;
  }
  int invoke(const GstTensorMemory* in, GstTensorMemory* out) override {
    const weir::infer::CallGate::Visit visit(*gate);
    if (!visit)
      throw weir::Failure(
          {.code = weir::Code::CALLBACK_UNKNOWN,
           .what = "the filter " + name() + " is no longer registered",
           .offered = "a frame that arrived after the filter was unregistered",
           .needed = "a filter that stays registered while a pipeline uses it",
           .fix = "stop the pipeline before you call NNS_custom_easy_unregister()"});
    if (fixed) return call("its function", [&] { return fixed(data, prop(), in, out); });
    return call("its function",
                [&] { return dynamic(data, &prop()->input_meta, &prop()->output_meta, in, out); });
  }
  bool allocates() override { return false; }
  void destroy(void* memory) override { g_free(memory); }

 private:
  // This object keeps ownership of the names: readers of the copy must not free them.
  static void copy(const GstTensorsInfo& from, GstTensorsInfo* to) {
    to->num_tensors = from.num_tensors;
    to->format = from.format;
    for (size_t i = 0; i < from.num_tensors; ++i)
      if (const auto* tensor = tensor_at(from, i)) *room_at(*to, i) = *tensor;
  }

  GstTensorsInfo in_, out_;
};

int invoke(const weir_host* host, const weir_frame* in, weir_frame* out, void* data,
           weir_error* error) {
  weir::accept_host(host);
  return weir::guarded(error,
                       [&] { return static_cast<FilterModel*>(data)->invoke(*in, *out) ? 0 : 1; });
}

int resolve(const weir_host* host, const weir_tensor_info* in, uint32_t n_in, weir_tensor_info* out,
            uint32_t n_out, void* data, weir_error* error) {
  weir::accept_host(host);
  return weir::guarded(error, [&] {
    static_cast<FilterModel*>(data)->resolve({in, n_in}, {out, n_out});
    return 0;
  });
}

std::shared_ptr<EasyFunction> make_function(const char* name, NNS_custom_invoke fixed,
                                            NNS_custom_invoke_dynamic dynamic, void* data,
                                            const GstTensorsInfo& in, const GstTensorsInfo* out) {
  const weir_option options[] = {{"invoke-dynamic", dynamic ? "true" : "false"}};
  const char* const paths[] = {name};
  const weir::OpenRequest request{paths, weir::Options(options, 1), "", 0};
  auto function = std::make_shared<EasyFunction>(
      std::make_unique<Properties>("custom-easy", name, request), in, out);
  function->fixed = fixed;
  function->dynamic = dynamic;
  function->data = data;
  return function;
}

int add(const char* caller, const char* name, NNS_custom_invoke fixed,
        NNS_custom_invoke_dynamic dynamic, void* data, const GstTensorsInfo* in,
        const GstTensorsInfo* out) {
  const auto function =
      fixed ? reinterpret_cast<const void*>(fixed) : reinterpret_cast<const void*>(dynamic);
  if (!given(caller, {name, function, in}) || (!dynamic && !given(caller, {out}))) return -EINVAL;
  return guarded_errno(caller, [&] {
    weir::accept_host(&weir::infer::host());
    const auto easy = make_function(name, fixed, dynamic, data, *in, out);
    auto model = std::make_unique<FilterModel>(easy);
    weir_filter filter{};
    filter.struct_size = sizeof filter;
    filter.flags = dynamic ? uint32_t{WEIR_FILTER_DYNAMIC} : 0;
    filter.n_inputs = static_cast<uint32_t>(model->inputs().size());
    filter.inputs = model->inputs().data();
    // The number of flexible outputs is known.
    const bool open = !dynamic && model->outputs().empty();
    const auto opened = open_tensors(open ? std::min(out->num_tensors, kMaxTensors) : 0);
    const auto outputs = open ? std::span<const weir_tensor_info>(opened.infos) : model->outputs();
    filter.n_outputs = static_cast<uint32_t>(outputs.size());
    filter.outputs = outputs.data();
    filter.resolve = open ? resolve : nullptr;
    filter.invoke = invoke;
    filter.data = model.get();
    filter.release = [](void* data) { delete static_cast<FilterModel*>(data); };
    weir_error* error = nullptr;
    const int code = weir_filter_register(name, &filter, &error);
    if (code == WEIR_OK) {
      static_cast<void>(model.release());
      gates().add(name, easy->gate);
    }
    return to_errno(caller, code, error);
  });
}

}  // namespace

int NNS_custom_easy_register(const char* name, NNS_custom_invoke func, void* data,
                             const GstTensorsInfo* in_info, const GstTensorsInfo* out_info) {
  return add(__func__, name, func, nullptr, data, in_info, out_info);
}

int NNS_custom_easy_dynamic_register(const char* name, NNS_custom_invoke_dynamic func, void* data,
                                     const GstTensorsInfo* in_info) {
  return add(__func__, name, nullptr, func, data, in_info, nullptr);
}

int NNS_custom_easy_unregister(const char* name) {
  if (!given(__func__, {name})) return -EINVAL;
  const char* const caller = __func__;
  return or_else(caller, -ENOMEM, [&] {
    const int code = weir_filter_unregister(name);
    if (code == WEIR_OK)
      if (const auto gate = gates().remove(name)) (*gate)->close();
    return to_errno(caller, code);
  });
}
