// Counts uses: a pipeline is freed by the thread that destroys it, never by a streaming thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline.hpp"

#include <cstdio>
#include <utility>

#include "core/config/ini.hpp"
#include "core/config/nnstreamer.hpp"
#include "core/text/text.hpp"
#include "weir/c_error.hpp"

namespace weir::application {
namespace {

struct Named {
  std::string name, kind;
  int depth;
};

Result<std::vector<Named>> list_elements(weir_pipeline* pipeline) {
  std::vector<Named> out;
  const auto add = [](const char* name, const char* kind, int depth, void* data) {
    static_cast<std::vector<Named>*>(data)->push_back({name, kind, depth});
  };
  CError error;
  const int result = weir_pipeline_elements(pipeline, add, &out, error.place());
  if (result < 0) return error.take(result);
  return out;
}

ml_pipeline_state_e to_ml_state(int state) {
  if (state == WEIR_PIPELINE_PLAYING) return ML_PIPELINE_STATE_PLAYING;
  return state == WEIR_PIPELINE_PAUSED ? ML_PIPELINE_STATE_PAUSED : ML_PIPELINE_STATE_NULL;
}

// Logs them once per process.
void log_faults(const config::NnstreamerConfiguration& configuration) {
  static std::once_flag reported;
  if (configuration.faults().empty()) return;
  std::call_once(reported, [&configuration] {
    for (const auto& fault : configuration.faults())
      std::fprintf(stderr, "weir: configuration: %s\n", fault.message().c_str());
  });
}

// Reads [element-restriction] of nnstreamer.ini and NNSTREAMER_element-restriction_KEY again;
// nullopt: every element is allowed. An error when a configuration file exists and cannot be read
// or parsed, because it may restrict elements.
Result<std::optional<ElementRestriction>> element_restriction() {
  using None = std::optional<ElementRestriction>;
  constexpr const char* kGroup = "element-restriction";
  const auto configuration = config::NnstreamerConfiguration::load();
  if (const auto& unread = configuration.unread()) {
    Error error = *unread;
    error.what = "a pipeline cannot be checked against [element-restriction]: " + error.what;
    return error;
  }
  log_faults(configuration);
  const auto enabled = configuration.find(kGroup, "enable_element_restriction");
  if (!enabled || !config::truth(enabled->value, false)) return None();
  ElementRestriction out{{}, enabled->origin};
  const auto elements = configuration.find(kGroup, "restricted_elements");
  if (!elements) return None(std::move(out));
  out.origin = elements->origin;
  for (const auto word : split(elements->value, ",; "))
    if (!strip(word).empty()) out.allowed.emplace_back(strip(word));
  return None(std::move(out));
}

}  // namespace

int Pipeline::parse(const char* text, const std::optional<ElementRestriction>& restriction,
                    weir_pipeline** pipeline, weir_error** error) {
  if (!restriction) return weir_pipeline_parse(text, pipeline, error);
  std::vector<const char*> allowed;
  for (const auto& name : restriction->allowed) allowed.push_back(name.c_str());
  return weir_pipeline_parse_allowed(text, allowed.data(), static_cast<uint32_t>(allowed.size()),
                                     pipeline, error);
}

std::variant<std::shared_ptr<Pipeline>, Refusal> Pipeline::construct(const char* text,
                                                                     StateCallback callback) {
  const auto restriction = element_restriction();
  if (!restriction) return Refusal{ML_ERROR_PERMISSION_DENIED, restriction.error()};
  std::shared_ptr<Pipeline> out(new Pipeline);
  out->state_callback_ = callback;
  CError error;
  const int result = parse(text, *restriction, &out->pipeline_, error.place());
  if (result < 0) return refusal(error.take(result));
  if (result > 0) {
    Error forbidden = error.take(-WEIR_OPTION_VALUE);
    forbidden.fix = "add the element to restricted_elements of [element-restriction] in " +
                    (*restriction)->origin;
    return Refusal{ML_ERROR_PERMISSION_DENIED, std::move(forbidden)};
  }
  if (auto status = out->connect(); !status) return refusal(status.error());
  return out;
}

Status Pipeline::connect() {
  const auto elements = list_elements(pipeline_);
  if (!elements) return elements.error();
  for (const auto& element : *elements) {
    if (element.depth == 0) kinds_.emplace(element.name, element.kind);
    if (element.kind != "tensor_sink" && element.kind != "appsink") continue;
    auto& sink = sinks_[element.name] = std::make_unique<SinkCallbacks>(this);
    CError error;
    const int result = weir_pipeline_on_frame(pipeline_, element.name.c_str(),
                                              SinkCallbacks::on_frame, sink.get(), error.place());
    if (result < 0) return error.take(result);
  }
  if (!state_callback_.function) return ok();
  CError error;
  return error.status(weir_pipeline_on_state(pipeline_, on_state, this, error.place()));
}

Pipeline::~Pipeline() {
  close();  // for a pipeline whose construction failed
}

void Pipeline::on_state(int state, void* data) {
  const auto* self = static_cast<const Pipeline*>(data);
  const InCallback here(self);
  self->state_callback_.function(to_ml_state(state), self->state_callback_.data);
}

Result<Pipeline::Use> Pipeline::use() {
  std::lock_guard lock(mutex_);
  if (closed_)
    return Error{.code = Code::OPTION_VALUE, .what = "the pipeline of this handle was destroyed"};
  ++uses_;
  return Use(shared_from_this());
}

void Pipeline::leave() {
  std::lock_guard lock(mutex_);
  --uses_;
  left_.notify_all();
}

Status Pipeline::not_from_its_callback() const {
  if (pipeline_of_callback() != this) return ok();
  return Error{.code = Code::CANCELLED,
               .what = "a callback cannot change the state of its own pipeline",
               .offered = "a call in a callback, for which the call would wait",
               .needed = "a call on another thread",
               .fix = "return from the callback, and make the call on another thread"};
}

Status Pipeline::stop() {
  const auto pipeline = use();
  if (!pipeline) return pipeline.error();
  CError error;
  return error.status(weir_pipeline_stop(pipeline->get(), error.place()));
}

void Pipeline::close() {
  {
    std::lock_guard lock(mutex_);
    closed_ = true;
  }
  if (pipeline_) weir_pipeline_stop(pipeline_, nullptr);  // ends waiting calls and callbacks
  std::unique_lock lock(mutex_);
  left_.wait(lock, [this] { return uses_ == 0; });
  weir_pipeline* pipeline = std::exchange(pipeline_, nullptr);
  lock.unlock();
  weir_pipeline_free(pipeline);
}

SinkCallbacks* Pipeline::sink(const std::string& name) const {
  const auto found = sinks_.find(name);
  return found == sinks_.end() ? nullptr : found->second.get();
}

std::string Pipeline::get_kind(const std::string& name) const {
  const auto found = kinds_.find(name);
  return found == kinds_.end() ? "" : found->second;
}

Result<Pipeline::Use> use_pipeline(void* handle) {
  const auto found = Handles::all().find<Pipeline>(handle, "pipe");
  if (!found) return found.error();
  return (*found)->use();
}

Status check_kind(const Pipeline::Use& pipeline, const char* name, const std::string& kinds) {
  CError error;
  const int result = weir_pipeline_property_type(pipeline.get(), name, "name", error.place());
  if (result < 0) return error.take(result);
  const std::string kind = pipeline->get_kind(name);
  const bool any = kinds.empty() || kinds == kind || kinds.starts_with(kind + " or ") ||
                   kinds.ends_with(" or " + kind);
  if (any && (kinds.empty() || !kind.empty())) return ok();
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "the element " + std::string(name) + " does not support this call",
      .offered = kind.empty() ? "an element inside a bin, not in the pipeline description" : kind,
      .needed = kinds};
}

}  // namespace weir::application
