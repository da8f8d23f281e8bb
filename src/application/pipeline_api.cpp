// ml_pipeline_construct to ml_pipeline_destroy; sinks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline_part.hpp"

namespace {

using namespace weir;
using namespace weir::application;

class Sink : public PipelinePart {
 public:
  static constexpr const char* kKind = "sink";
  Sink(std::weak_ptr<Pipeline> pipeline, std::string name, std::shared_ptr<SinkCallback> callback)
      : PipelinePart(std::move(pipeline), std::move(name)), callback_(std::move(callback)) {}
  const char* kind() const noexcept override { return kKind; }
  // Waits for the callback on other threads.
  void close() override {
    if (const auto pipeline = use()) (*pipeline)->sink(name())->remove(callback_);
    callback_->gate.close();
  }

 private:
  const std::shared_ptr<SinkCallback> callback_;
};

using StateCall = int (*)(weir_pipeline*, weir_error**);

Status call(const Pipeline::Use& pipeline, StateCall function) {
  CError error;
  return error.status(function(pipeline.get(), error.place()));
}

// Runs `body`, which returns a Status, with the pipeline; fails in its own callbacks.
template <class Body>
int change(ml_pipeline_h pipe, Body&& body) {
  return guarded([&] {
    const auto pipeline = use_pipeline(pipe);
    if (!pipeline) return fail(pipeline.error());
    if (auto status = (*pipeline)->not_from_its_callback(); !status) return fail(status.error());
    const Status status = body(*pipeline);
    if (status || status.error().code == Code::CANCELLED) return to_ml_error(status);
    return fail(Refusal{ML_ERROR_STREAMS_PIPE, status.error()});
  });
}

Error several_sinks(const std::string& name) {
  return {.code = Code::OPTION_VALUE,
          .what = "several sinks of the pipeline have this name",
          .offered = name + " in several bins",
          .needed = "a name of its own for each sink in a bin",
          .fix = "name=" + name + "2 for one of them"};
}

ml_pipeline_state_e to_ml_state(GstState state) {
  switch (state) {
    case GST_STATE_READY:
      return ML_PIPELINE_STATE_READY;
    case GST_STATE_PAUSED:
      return ML_PIPELINE_STATE_PAUSED;
    case GST_STATE_PLAYING:
      return ML_PIPELINE_STATE_PLAYING;
    default:
      return ML_PIPELINE_STATE_NULL;
  }
}

}  // namespace

int ml_pipeline_construct(const char* pipeline_description, ml_pipeline_state_cb cb,
                          void* user_data, ml_pipeline_h* pipe) {
  return guarded([&] {
    if (!pipe) return fail(null_pointer("pipe"));
    if (!pipeline_description) return fail(null_pointer("pipeline_description"));
    *pipe = nullptr;
    auto made = Pipeline::construct(pipeline_description, {cb, user_data});
    if (const auto* refused = std::get_if<Refusal>(&made)) return fail(*refused);
    *pipe = Handles::all().add(std::get<0>(std::move(made)));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_pipeline_destroy(ml_pipeline_h pipe) {
  return guarded([&] {
    const auto found = Handles::all().find<Pipeline>(pipe, "pipe");
    if (!found) return fail(found.error());
    if (auto status = (*found)->not_from_its_callback(); !status) return fail(status.error());
    if (auto status = (*found)->stop(); !status) return fail(status.error());
    const auto taken = Handles::all().take<Pipeline>(pipe, "pipe");
    if (!taken) return fail(taken.error());
    (*taken)->close();
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_pipeline_start(ml_pipeline_h pipe) {
  return change(pipe, [](const auto& pipeline) { return call(pipeline, weir_pipeline_start); });
}

int ml_pipeline_stop(ml_pipeline_h pipe) {
  return change(pipe, [](const auto& pipeline) { return call(pipeline, weir_pipeline_pause); });
}

int ml_pipeline_flush(ml_pipeline_h pipe, bool start) {
  return change(pipe, [start](const auto& pipeline) {
    if (auto status = pipeline->flush(); !status) return status;
    return start ? call(pipeline, weir_pipeline_start) : ok();
  });
}

int ml_pipeline_get_state(ml_pipeline_h pipe, ml_pipeline_state_e* state) {
  return guarded([&] {
    if (!state) return fail(null_pointer("state"));
    const auto pipeline = use_pipeline(pipe);
    if (!pipeline) return fail(pipeline.error());
    GstState now = GST_STATE_NULL;
    (void)(*pipeline)->get_state(GST_MSECOND, &now);
    *state = to_ml_state(now);
    CError error;
    const int result = weir_pipeline_wait(pipeline->get(), 0, error.place());
    return result < 0 ? fail(Refusal{ML_ERROR_STREAMS_PIPE, error.take(result)})
                      : static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_pipeline_sink_register(ml_pipeline_h pipe, const char* sink_name, ml_pipeline_sink_cb cb,
                              void* user_data, ml_pipeline_sink_h* sink_handle) {
  return guarded([&] {
    if (!sink_handle) return fail(null_pointer("sink_handle"));
    if (!sink_name || !cb) return fail(null_pointer("sink_name or cb"));
    const auto pipeline = use_pipeline(pipe);
    if (!pipeline) return fail(pipeline.error());
    if (auto status = check_kind(*pipeline, sink_name, "tensor_sink or appsink"); !status)
      return fail(status.error());
    SinkCallbacks* const sink = (*pipeline)->sink(sink_name);
    if (!sink) return fail(several_sinks(sink_name));
    const auto callback = std::make_shared<SinkCallback>();
    callback->function = cb;
    callback->data = user_data;
    sink->add(callback);
    *sink_handle = (*pipeline)->add_part(
        std::make_shared<Sink>((**pipeline).weak_from_this(), sink_name, callback));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_pipeline_sink_unregister(ml_pipeline_sink_h sink_handle) {
  return release_part<Sink>(sink_handle, "sink_handle");
}
