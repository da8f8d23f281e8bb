// ml_pipeline_src_*.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <algorithm>
#include <utility>

#include "pipeline_part.hpp"
#include "tensors_data.hpp"

namespace {

using namespace weir;
using namespace weir::application;

class Source : public PipelinePart {
 public:
  static constexpr const char* kKind = "source";
  using PipelinePart::PipelinePart;
  const char* kind() const noexcept override { return kKind; }
  // Returns false if the handle was released meanwhile.
  bool set_events(const ml_pipeline_src_callbacks_s& functions, ml_pipeline_src_h handle,
                  void* data, Pipeline& pipeline) {
    std::lock_guard lock(mutex_);
    if (is_closed_) return false;
    const bool is_new = !events_;
    if (is_new) events_ = std::make_shared<SourceEvents>(name(), &pipeline);
    events_->set(functions, handle, data);
    if (is_new) pipeline.connect_events(events_);
    return true;
  }
  // Waits for functions on other threads. Calls may still use this object.
  void close() override {
    std::unique_lock lock(mutex_);
    is_closed_ = true;
    const auto events = std::move(events_);
    lock.unlock();
    if (events) events->close();
  }

 private:
  std::mutex mutex_;  // guards the rest
  bool is_closed_ = false;
  std::shared_ptr<SourceEvents> events_;
};

Error no_policy(int policy) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "policy is not a value of ml_pipeline_buf_policy_e",
               .offered = std::to_string(policy),
               .needed =
                   "ML_PIPELINE_BUF_POLICY_AUTO_FREE, ML_PIPELINE_BUF_POLICY_DO_NOT_FREE or "
                   "ML_PIPELINE_BUF_SRC_EVENT_EOS"};
}

// Runs `body` with the lease of the source's pipeline and its name.
template <class Body>
int with_source(ml_pipeline_src_h handle, Body&& body) {
  return guarded([&] {
    const auto source = Handles::all().find<Source>(handle, "src_handle");
    if (!source) return fail(source.error());
    const auto pipeline = (*source)->use();
    return pipeline ? body(**source, *pipeline) : fail(pipeline.error());
  });
}

// Whether the pad has caps or can get some from the elements after it.
bool has_caps(const Pipeline::Use& pipeline, const std::string& name) {
  const ElementRef element(weir_pipeline_get_element(pipeline.get(), name.c_str()));
  if (!element) return true;  // the pipeline is being flushed; the next call returns its error
  GstPad* const pad = gst_element_get_static_pad(element.get(), "src");
  GstCaps* caps = gst_pad_get_current_caps(pad);
  if (!caps) caps = gst_pad_get_allowed_caps(pad);
  const bool out = caps && !gst_caps_is_empty(caps);
  if (caps) gst_caps_unref(caps);
  gst_object_unref(pad);
  return out;
}

// The descriptions of the tensors that an appsrc needs; none if it leaves a choice.
Result<std::vector<weir_tensor_info>> needed_infos(const Pipeline::Use& pipeline,
                                                   const std::string& name) {
  if (!has_caps(pipeline, name))
    return Error{.code = Code::CANCELLED,
                 .what = "the appsrc " + name + " has no caps",
                 .offered = "an appsrc without an element that takes its frames",
                 .needed = "an element after it",
                 .fix = "appsrc name=" + name + " ! tensor_sink"};
  std::vector<weir_tensor_info> infos(ML_TENSOR_SIZE_LIMIT);
  CError error;
  const int count = weir_pipeline_source_tensors(pipeline.get(), name.c_str(), infos.data(),
                                                 ML_TENSOR_SIZE_LIMIT, error.place());
  if (count < 0) return error.take(count);
  infos.resize(std::min(infos.size(), static_cast<size_t>(count)));
  return infos;
}

// Like NNStreamer, compares the sizes of tensors, not their types.
void take_needed_types(const std::vector<weir_tensor_info>& needed,
                       std::vector<weir_tensor>* tensors) {
  if (needed.size() != tensors->size()) return;
  for (size_t i = 0; i < needed.size(); ++i)
    if (to_spec(needed[i]).bytes() == (*tensors)[i].bytes) (*tensors)[i].info = needed[i];
}

int end(const Source& source, const Pipeline::Use& pipeline) {
  CError error;
  const int result = pipeline->end(source.name(), error.place());
  return result < 0 ? fail(pipeline->refused(error.take(result))) : static_cast<int>(ML_ERROR_NONE);
}

int push(const Source& source, const Pipeline::Use& pipeline, const TensorsData& data) {
  const auto needed = needed_infos(pipeline, source.name());
  if (!needed) return fail(needed.error());
  auto tensors = data.c_tensors();
  take_needed_types(*needed, &tensors);
  CError error;
  const int result =
      weir_pipeline_push(pipeline.get(), source.name().c_str(), tensors.data(),
                         static_cast<uint32_t>(tensors.size()), -1, -1, error.place());
  if (result >= 0) return ML_ERROR_NONE;
  if (result == -WEIR_CANCELLED && pipeline->has_ended(source.name()))
    return fail(Refusal{ML_ERROR_STREAMS_PIPE, error.take(result)});
  return fail(pipeline->refused(error.take(result)));
}

}  // namespace

int ml_pipeline_src_get_handle(ml_pipeline_h pipe, const char* src_name,
                               ml_pipeline_src_h* src_handle) {
  return get_part<Source>(pipe, src_name, "appsrc", src_handle);
}

int ml_pipeline_src_release_handle(ml_pipeline_src_h src_handle) {
  return release_part<Source>(src_handle, "src_handle");
}

int ml_pipeline_src_input_data(ml_pipeline_src_h src_handle, ml_tensors_data_h data,
                               ml_pipeline_buf_policy_e policy) {
  return with_source(src_handle, [&](const Source& source, const Pipeline::Use& pipeline) {
    if (policy == ML_PIPELINE_BUF_SRC_EVENT_EOS) return end(source, pipeline);
    if (policy != ML_PIPELINE_BUF_POLICY_AUTO_FREE && policy != ML_PIPELINE_BUF_POLICY_DO_NOT_FREE)
      return fail(no_policy(policy));
    const auto found = Handles::all().find<TensorsData>(data, "data");
    if (!found) return fail(found.error());
    const int result = push(source, pipeline, **found);
    const bool is_consumed = result != ML_ERROR_INVALID_PARAMETER && result != ML_ERROR_TRY_AGAIN;
    if (is_consumed && policy == ML_PIPELINE_BUF_POLICY_AUTO_FREE)
      (void)Handles::all().take<TensorsData>(data, "data");
    return result;
  });
}

int ml_pipeline_src_input_data_eos(ml_pipeline_src_h src_handle) {
  return with_source(src_handle, end);
}

int ml_pipeline_src_get_tensors_info(ml_pipeline_src_h src_handle, ml_tensors_info_h* info) {
  return with_source(src_handle, [&](const Source& source, const Pipeline::Use& pipeline) {
    if (!info) return fail(null_pointer("info"));
    const auto needed = needed_infos(pipeline, source.name());
    if (!needed) return fail(needed.error());
    TensorSpecs specs;
    for (const auto& each : *needed) specs.push_back(to_spec(each));
    *info = new_info(std::move(specs));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_pipeline_src_set_event_cb(ml_pipeline_src_h src_handle, ml_pipeline_src_callbacks_s* cb,
                                 void* user_data) {
  return with_source(src_handle, [&](Source& source, const Pipeline::Use& pipeline) {
    if (!cb) return fail(null_pointer("cb"));
    if (source.set_events(*cb, src_handle, user_data, *pipeline))
      return static_cast<int>(ML_ERROR_NONE);
    return fail(Error{.code = Code::OPTION_VALUE,
                      .what = "src_handle is a handle that was destroyed or released"});
  });
}
